"""The values of probes."""

import unittest

import numpy as np

import rigid_body
from tidelock.clock import PREDICTOR, StageTime
from tidelock.solver import probe_values

from . import scene

# Columns of the kinds that a solver in Python computes; `suite/python.rs` compares them with the built-in solver's.
COLUMNS = {"material-point": 11, "body-motion": 6, "body-force": 2, "support-reaction": 2, "body-sums": 12}


class Columns(unittest.TestCase):
    def test_each_kind_has_as_many_values_as_columns(self):
        for kind, columns in {**COLUMNS, "contact": 6, "of a later version": 3}.items():
            with self.subTest(kind=kind):
                setup = scene.setup([scene.lattice(4, 4, (0.0, 0.0))])
                probe = setup.message.probes.add(name="probe", kind=kind, columns=["quantity"] * columns)
                probe.arguments.add(name="body", index=0)
                if kind == "material-point":
                    at = probe.arguments.add(name="at_m").point_m
                    at.components[:] = [2 * scene.SPACING] * 2
                solver = rigid_body.RigidBodies(setup)
                forces = np.zeros((len(solver.ids), 2))
                _, budget = solver.advance(solver.state, solver.state, forces, StageTime(0, PREDICTOR, 0.0, scene.STEP))
                self.assertEqual(len(probe_values(solver, solver.state, forces, budget)), columns)


if __name__ == "__main__":
    unittest.main()
