"""The values of probes."""

import unittest

import numpy as np

import rigid_body
from tidelock.clock import PREDICTOR, StageTime
from tidelock.solver import PROBE_COLUMNS, probe_values

from . import scene


class Columns(unittest.TestCase):
    def test_each_kind_has_as_many_values_as_columns(self):
        for kind, columns in PROBE_COLUMNS.items():
            with self.subTest(kind=kind):
                setup = scene.setup([scene.lattice(4, 4, (0.0, 0.0))])
                probe = setup.message.probes.add(name="probe")
                if kind in ("motion", "body_force", "sums", "gap", "contact"):
                    setattr(probe, kind, 0)
                else:
                    getattr(probe, kind).SetInParent()
                if kind == "material_point":
                    at = probe.material_point.reference_position_m
                    at.components[:] = [2 * scene.SPACING] * 2
                solver = rigid_body.RigidBodies(setup)
                forces = np.zeros((len(solver.ids), 2))
                _, budget = solver.advance(solver.state, solver.state, forces, StageTime(0, PREDICTOR, 0.0, scene.STEP))
                self.assertEqual(len(probe_values(solver, solver.state, forces, budget)), columns)

    def test_every_kind_of_the_protocol_is_known(self):
        kinds = scene.protocol.setup.SolidProbe.DESCRIPTOR.oneofs_by_name["kind"].fields
        self.assertEqual([field.name for field in kinds], list(PROBE_COLUMNS))


if __name__ == "__main__":
    unittest.main()
