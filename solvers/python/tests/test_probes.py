"""The values of probes."""

import unittest

import numpy as np

import rigid_body
from tidelock.clock import PREDICTOR, StageTime
from tidelock.solver import probe_values

from . import scene

# Columns of the kinds that a solver in Python computes; `suite/python.rs` compares them with the built-in solver's.
COLUMNS = {"material-point": 11, "body-motion": 6, "body-force": 2, "support-reaction": 2, "body-sums": 12}
IN_SPACE = {"material-point": 16, "body-motion": 13, "body-force": 3, "support-reaction": 3, "body-sums": 19}


class Columns(unittest.TestCase):
    def test_each_kind_has_as_many_values_as_columns(self):
        self._compare({**COLUMNS, "contact": 6, "of a later version": 3}, scene.lattice(4, 4, (0.0, 0.0)))
        self._compare({**IN_SPACE, "contact": 8}, scene.spatial_lattice((4, 4, 3), (0.0, 0.0, 0.0)))

    def _compare(self, kinds, block):
        dimensions = block.shape[1]
        for kind, columns in kinds.items():
            with self.subTest(kind=kind, dimensions=dimensions):
                setup = scene.setup([block])
                probe = setup.message.probes.add(name="probe", kind=kind, columns=["quantity"] * columns)
                probe.arguments.add(name="body", index=0)
                if kind == "material-point":
                    at = probe.arguments.add(name="at_m").point_m
                    at.components[:] = [2 * scene.SPACING] * dimensions
                solver = rigid_body.RigidBodies(setup)
                forces = np.zeros((len(solver.ids), dimensions))
                _, budget = solver.advance(solver.state, solver.state, forces, StageTime(0, PREDICTOR, 0.0, scene.STEP))
                self.assertEqual(len(probe_values(solver, solver.state, forces, budget)), columns)


if __name__ == "__main__":
    unittest.main()
