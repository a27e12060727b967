"""Rigid bodies in space."""

import unittest

import grpc
import numpy as np

import beam
import rigid_body
from tidelock import Refused, Setup, Solver, StageTime, protocol
from tidelock.clock import CORRECTOR, PREDICTOR
from tidelock.server import Server
from tidelock.solver import probe_values

from . import scene

# Round-off of a few thousand operations.
TOLERANCE = 1e-12


def bodies(**options):
    """Two bodies, of which the first rotates, and a single particle."""
    blocks = [scene.spatial_lattice((5, 3, 4), (0.1, 0.2, 0.0)), scene.spatial_lattice((2, 4, 2), (0.4, -0.1, 0.1)),
              np.array([[-0.2, 0.5, 0.3]])]
    velocity = np.tile([0.4, -0.2, 0.1], (sum(map(len, blocks)), 1))
    arm = blocks[0] - blocks[0].mean(axis=0)
    velocity[: len(arm)] += np.cross([3.0, -5.0, 2.0], arm)
    return scene.setup(blocks, velocity=velocity, **options)


class MoreTorque(rigid_body.SpatialBodies):
    """Gains 5 % more angular momentum about x than the forces on its samples explain."""

    def advance(self, start, stage, forces, time):
        state, budget = super().advance(start, stage, forces, time)
        state[:, 10] += 0.05 * (state - start)[:, 10]
        return state, budget


def stepped(solver, time_step, steps, forces):
    """The state after `steps`, with the `forces` on the points of a state."""
    state = solver.state
    for step in range(steps):
        start = state
        for stage in (PREDICTOR, CORRECTOR):
            time = StageTime(step, stage, step * time_step, time_step)
            state, _ = solver.advance(start, state, forces(state), time)
    return state


class Motion(unittest.TestCase):
    def test_a_rotation_that_the_velocities_describe_is_kept(self):
        solver = rigid_body.RigidBodies(bodies())
        self.assertIsInstance(solver, rigid_body.SpatialBodies)
        position, velocity = solver.kinematics(solver.state)
        np.testing.assert_allclose(position, solver.setup.position, rtol=0, atol=1e-15)
        # The density varies, so that the mean velocity is not that of the middle.
        np.testing.assert_allclose(velocity, solver.setup.velocity, rtol=0, atol=1e-14)

    def test_a_free_body_keeps_angular_momentum_and_energy(self):
        solver = rigid_body.RigidBodies(bodies(gravity=(0.0, 0.0, 0.0)))
        none = np.zeros_like(solver.setup.position)
        drifts = []
        for refinement in (1, 2):
            end = stepped(solver, 1e-3 / refinement, 200 * refinement, lambda state: none)
            np.testing.assert_array_equal(end[:, 10:13], solver.state[:, 10:13])
            drifts.append(abs(solver.energies(end)[0] - solver.energies(solver.state)[0]))
            # The axis of rotation moves in the body: no principal axis.
            self.assertGreater(np.linalg.norm(solver._spin(end)[0] - [3.0, -5.0, 2.0]), 0.1)
        # The midpoint rule keeps the energy to third order at least.
        self.assertLess(drifts[0], 1e-7)
        self.assertGreater(np.log2(drifts[0] / drifts[1]), 1.8)

    def test_it_converges_in_second_order(self):
        solver = rigid_body.RigidBodies(bodies())
        pull = lambda state: -0.1 * (solver.kinematics(state)[0] - solver.setup.position - 0.02)
        # The rotation alone: errors of the positions would hide it.
        ends = [stepped(solver, 2e-3 / n, 50 * n, pull)[:, solver.rotation] for n in (1, 2, 4)]
        coarse, fine = (np.linalg.norm(a - b) for a, b in zip(ends, ends[1:]))
        self.assertGreater(np.log2(coarse / fine), 1.8)

    def test_the_budget_closes(self):
        for implicit in (False, True):
            with self.subTest(implicit=implicit):
                played = scene.Played(rigid_body.RigidBodies(bodies(implicit=implicit)), strength=0.05)
                self.assertTrue(played.last.HasField("finished"), played.last)
                stages = list(played.stages())
                self.assertEqual(len(stages), 100)
                for at, budget in stages:
                    self.assertTrue(budget.HasField("angular"), at)
                    self.assertLess(scene.residual(budget), TOLERANCE, at)
                # Not a sum of nothing, and about all axes.
                torque = np.abs(budget.duration_s * np.array(budget.interface.torque_n_m.components))
                self.assertGreater(torque.min() / budget.angular.gross_kg_m2_per_s, 1e-6)

    def test_more_torque_than_the_forces_give_breaks_it(self):
        _, budget = next(scene.Played(MoreTorque(bodies()), strength=0.05).stages())
        self.assertGreater(scene.residual(budget), 1e-6)

    def test_probes_state_rotation_and_spin(self):
        setup = bodies()
        probe = setup.message.probes.add(name="probe", kind="body-motion", columns=["quantity"] * 13)
        probe.arguments.add(name="body", index=0)
        solver = rigid_body.RigidBodies(setup)
        values = probe_values(solver, solver.state, 0.0 * setup.position, None)
        np.testing.assert_allclose(values[6:10], [1.0, 0.0, 0.0, 0.0])
        np.testing.assert_allclose(values[10:], [3.0, -5.0, 2.0], rtol=1e-10)

    def test_stresses_in_space_have_invariants(self):
        class Loaded(rigid_body.SpatialBodies):
            def stress(self, state, point):
                return 1.0, 1.0, 4.0, 0.0, 0.0, 0.0

        setup = bodies()
        probe = setup.message.probes.add(name="probe", kind="material-point", columns=["quantity"] * 16)
        probe.arguments.add(name="body", index=0)
        probe.arguments.add(name="at_m").point_m.components[:] = (0.12, 0.21, 0.02)
        solver = Loaded(setup)
        values = probe_values(solver, solver.state, 0.0 * setup.position, None)
        # Uniaxial tension of 3 Pa under an even pressure.
        np.testing.assert_allclose(values[12:15], [3.0, 4.0, 1.0], rtol=1e-14)


class Refusals(unittest.TestCase):
    def test_open_states_the_tensor_of_inertia(self):
        setup = bodies()
        server = Server(rigid_body.RigidBodies, 60.0)
        reply = server._open_reply(rigid_body.RigidBodies(setup))
        self.assertEqual([field.components for field in reply.fields_sent], [3, 3, 1])
        self.assertEqual([field.components for field in reply.fields_needed], [3])
        self.assertEqual(len(reply.extent.boxes_m), 48)
        for body, report in zip(setup.bodies, reply.bodies, strict=True):
            mass = setup.mass[body.particles]
            x, y, z = (setup.position[body.particles] - mass @ setup.position[body.particles] / mass.sum()).T
            cells = mass @ setup.volume[body.particles] ** (2 / 3) / 6
            self.assertFalse(report.HasField("inertia_kg_m2"))
            expected = [mass @ (y**2 + z**2) + cells, mass @ (x**2 + z**2) + cells, mass @ (x**2 + y**2) + cells,
                        -mass @ (x * y), -mass @ (y * z), -mass @ (x * z)]
            np.testing.assert_allclose(report.inertia_tensor_kg_m2, expected, rtol=0, atol=1e-13 * max(expected))

    def test_vectors_of_the_plane_are_refused_in_space(self):
        message = bodies().message
        message.run.body_force.gravity_m_per_s2.components.pop()
        with self.assertRaisesRegex(Refused, r"gravity_m_per_s2`: has 2 components, must have 3 in a run of 3 dimensions"):
            Setup(message)
        message = bodies().message
        message.particles.positions_m = message.particles.positions_m[:-8]
        with self.assertRaisesRegex(Refused, r"positions_m`: has \d+ bytes, must have 77 x 3 numbers x 8 bytes"):
            Setup(message)
        message.run.dimensions = 4
        with self.assertRaisesRegex(Refused, r"`open.solid.run.dimensions`: is 4, must be 2 or 3"):
            Setup(message)

    def test_a_solver_of_the_plane_refuses_space_by_name(self):
        class Ended(Exception):
            pass

        class Context:
            def abort(self, code, text):
                raise Ended(code, text)

        described = Server(beam.Beam, 60.0).Describe(None, None)
        self.assertEqual(list(described.dimensions), [2])
        self.assertEqual(list(Server(rigid_body.RigidBodies, 60.0).Describe(None, None).dimensions), [2, 3])
        self.assertEqual(Solver.dimensions, (2,))
        request = protocol.participant.OpenRequest(token="0123456789abcdef", solid=bodies().message)
        request.protocol.major = 2
        with self.assertRaises(Ended) as ended:
            Server(beam.Beam, 60.0).Open(request, Context())
        code, text = ended.exception.args
        self.assertEqual(code, grpc.StatusCode.INVALID_ARGUMENT)
        self.assertEqual(text, "`open.solid.run.dimensions`: is 3, this solver computes in 2")


if __name__ == "__main__":
    unittest.main()
