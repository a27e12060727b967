"""The budget of the angular momentum, and the reports of the motion in frames and handshake."""

import unittest

import numpy as np

import beam
import rigid_body
from tidelock import StageBudget, Torques, protocol
from tidelock.clock import PREDICTOR
from tidelock.server import Server

from . import scene

ACCOUNTS = protocol.participant
TOLERANCE = 1e-12


def rigid(**options):
    """Two bodies and a single particle; the first rotates."""
    blocks = [scene.lattice(7, 4, (0.1, 0.2), 0.3), scene.lattice(1, 2, (0.4, -0.1)), scene.lattice(1, 1, (-0.2, 0.5))]
    velocity = np.tile([0.4, -0.2], (sum(len(block) for block in blocks), 1))
    arm = blocks[0] - blocks[0].mean(axis=0)
    velocity[: len(arm)] += 6.0 * np.c_[-arm[:, 1], arm[:, 0]]
    return scene.setup(blocks, velocity=velocity, **options)


def cantilever(corner=(0.2, -0.3), across=False, **options):
    """A beam of 3 x 12 particles, of which the first three rows are held; `across`: it stands along x."""
    block = scene.lattice(3, 12, (0.0, 0.0))
    held = np.flatnonzero(block[:, 1] < 3 * scene.SPACING)
    block = (block[:, ::-1] if across else block) + np.array(corner)
    return scene.setup([block], formulation="total-lagrangian", held=held, **options)


class MoreTorque(rigid_body.RigidBodies):
    """Rotates 5 % more than the forces on its samples explain."""

    def advance(self, start, stage, forces, time):
        state, budget = super().advance(start, stage, forces, time)
        state[:, rigid_body.SPIN] += 0.05 * (state - start)[:, rigid_body.SPIN]
        return state, budget


class MoreInertia(rigid_body.RigidBodies):
    """Has 5 % more inertia than it reports."""

    def advance(self, start, stage, forces, time):
        self.inertia, own = 1.05 * self.inertia, self.inertia
        try:
            return super().advance(start, stage, forces, time)
        finally:
            self.inertia = own


class SentAtRest(rigid_body.RigidBodies):
    """Moves, but sends zero velocities."""

    def kinematics(self, state):
        position, velocity = super().kinematics(state)
        return position, 0.0 * velocity


class Rail(rigid_body.RigidBodies):
    """Slides along y without rotation, on a rail that reports its torque if `says`."""

    says = True

    def advance(self, start, stage, forces, time):
        state, budget = super().advance(start, stage, forces, time)
        free = state.copy()
        state[:, 3], state[:, rigid_body.SPIN] = start[:, 3], start[:, rigid_body.SPIN]
        stopped = (state - free) / time.duration
        budget.momentum, budget.supports = self.momentum(state), np.array([self.total @ stopped[:, 3], 0.0])
        if self.says:
            arm = stage[:, 1] - self.setup.origin[1]
            held = self.inertia @ stopped[:, 5] - (self.total * arm) @ stopped[:, 3]
            budget.torques = Torques(supports=held, gross=abs(held))
        return state, budget


class AngularBudget(unittest.TestCase):
    def closes(self, solver, half_steps=100):
        played = scene.Played(solver)
        self.assertTrue(played.last.HasField("finished"), played.last)
        stages = list(played.stages())
        self.assertEqual(len(stages), half_steps)
        for at, budget in stages:
            self.assertTrue(budget.HasField("angular"), at)
            self.assertLess(scene.residual(budget), TOLERANCE, at)
        # Not a sum of nothing: the forces turn the bodies.
        turned = max(abs(budget.duration_s * budget.interface.torque_n_m.components[2]) / budget.angular.gross_kg_m2_per_s
                     for _, budget in stages)
        self.assertGreater(turned, 1e-5)
        return played

    def breaks_at_once(self, solver):
        at, budget = next(scene.Played(solver).stages())
        self.assertEqual(at, "step 0 predictor")
        # Far above round-off: a twentieth of the torque is missing.
        self.assertGreater(scene.residual(budget), 1e-5)

    def test_rigid_bodies_close_it(self):
        played = self.closes(rigid_body.RigidBodies(rigid()))
        budget = played.reports[-1].corrector
        self.assertGreater(abs(scene.torque(budget, ACCOUNTS.ACCOUNT_TIME_SCHEME)), 1e-6)
        self.assertGreater(abs(scene.torque(budget, ACCOUNTS.ACCOUNT_BODY_FORCE)), 1e-3)

    def test_implicit_coupling_closes_it(self):
        played = self.closes(rigid_body.RigidBodies(rigid(implicit=True)))
        self.assertTrue(all(report.iterations == 3 for report in played.reports))

    def test_bodies_of_another_formulation_that_move_rigidly_close_it(self):
        block = [scene.lattice(5, 4, (0.1, 0.2))]
        self.closes(rigid_body.RigidBodies(scene.setup(block, formulation="total-lagrangian")))

    def test_more_torque_than_the_forces_give_breaks_it(self):
        self.breaks_at_once(MoreTorque(rigid()))

    def test_more_inertia_than_the_particles_have_breaks_it(self):
        self.breaks_at_once(MoreInertia(rigid()))

    def test_supports_of_rigid_bodies_enter_by_their_torque(self):
        self.closes(Rail(rigid()))

    def test_supports_without_torques_leave_no_budget(self):
        solver = Rail(rigid())
        solver.says = False
        for _, budget in scene.Played(solver).stages():
            self.assertFalse(budget.HasField("angular"))
            self.assertTrue(budget.HasField("gross_momentum_kg_m_per_s"))

    def test_the_beam_closes_it(self):
        for across in [False, True]:
            for gravity in [(0.7, -9.81), (9.81, 0.3)]:
                with self.subTest(across=across, gravity=gravity):
                    played = self.closes(beam.Beam(cantilever(across=across, gravity=gravity)))
                    budget = played.reports[-1].corrector
                    self.assertGreater(abs(scene.torque(budget, ACCOUNTS.ACCOUNT_SUPPORTS)), 1e-2)
                    self.assertGreater(abs(scene.torque(budget, ACCOUNTS.ACCOUNT_OWN_FORCES)), 1e-6)

    def test_a_beam_that_leaves_out_what_the_displaced_forces_add_breaks_it(self):
        class Plain(beam.Beam):
            def advance(self, *given):
                state, budget = super().advance(*given)
                budget.torques.own_forces = 0.0
                return state, budget

        worst = max(scene.residual(budget) for _, budget in scene.Played(Plain(cantilever())).stages())
        self.assertGreater(worst, 100 * TOLERANCE)

    def test_a_solver_that_deforms_and_states_no_torques_has_none(self):
        class Silent(beam.Beam):
            def advance(self, *given):
                state, budget = super().advance(*given)
                return state, StageBudget(budget.momentum, budget.body_force, budget.supports, budget.gross)

        _, budget = next(scene.Played(Silent(cantilever())).stages())
        self.assertFalse(budget.HasField("angular"))


def differences(played):
    """Largest difference of momentum and angular momentum in frames from their report, relative to gross.

    AUDIT OF THE SOLID'S FRAMES of peer.proto, from frames and set-up alone.
    """
    setup, frames = played.solver.setup, played.frames
    cells = np.bincount(setup.body, setup.mass * setup.volume / 6.0)

    def motion_of(frame):
        position, velocity = scene.arrays(frame)
        angular = setup.mass @ _cross(position - setup.origin, velocity)
        for k, body in enumerate(setup.bodies):
            own, mass = body.particles, setup.mass[body.particles]
            if len(own) > 1:
                arm = position[own] - mass @ position[own] / mass.sum()
                angular += cells[k] * (mass @ _cross(arm, velocity[own])) / (mass @ (arm**2).sum(axis=1))
        return setup.mass @ velocity, angular

    worst, start = [0.0, 0.0], motion_of(frames[0])
    for before, frame in zip(frames, frames[1:]):
        if before.stage == PREDICTOR:
            start = motion_of(before)
        momentum, angular = motion_of(frame)
        report = frame.previous.momentum
        change, turning = report.change_kg_m_per_s.components, report.angular.change_kg_m2_per_s.components
        off = np.linalg.norm(momentum - start[0] - change[:2]) / report.gross_kg_m_per_s
        turned = abs(angular - start[1] - turning[2]) / report.angular.gross_kg_m2_per_s
        worst = [max(worst[0], off), max(worst[1], turned)]
    return worst


def _cross(a, b):
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


class Reports(unittest.TestCase):
    def test_frames_report_the_budget_of_the_previous_half_step(self):
        played = scene.Played(rigid_body.RigidBodies(rigid()))
        self.assertFalse(played.frames[0].HasField("previous"))
        for frame, (_, budget) in zip(played.frames[1:], played.stages()):
            report = frame.previous.momentum
            self.assertEqual(report.change_kg_m_per_s, budget.momentum_change_kg_m_per_s)
            self.assertEqual(report.gross_kg_m_per_s, budget.gross_momentum_kg_m_per_s)
            self.assertEqual(report.angular, budget.angular)

    def test_the_motion_in_frames_agrees_with_the_report(self):
        self.assertLess(max(differences(scene.Played(rigid_body.RigidBodies(rigid())))), TOLERANCE)

    def test_velocities_sent_as_zero_do_not(self):
        self.assertGreater(differences(scene.Played(SentAtRest(rigid())))[0], 1e-3)

    def test_without_a_budget_no_angular_change_is_reported(self):
        solver = Rail(rigid())
        solver.says = False
        report = scene.Played(solver).frames[1].previous.momentum
        self.assertFalse(report.HasField("angular"))
        self.assertTrue(report.HasField("change_kg_m_per_s"))

    def test_a_rigid_rotation_of_the_set_up_is_kept(self):
        solver = rigid_body.RigidBodies(rigid())
        velocity = solver.kinematics(solver.state)[1]
        np.testing.assert_allclose(velocity, solver.setup.velocity, rtol=0, atol=1e-14)

    def test_open_says_what_moves_each_body(self):
        setup = rigid()
        reply = Server(rigid_body.RigidBodies, 60.0)._open_reply(rigid_body.RigidBodies(setup))
        self.assertEqual((reply.protocol.major, reply.protocol.minor), (2, 0))
        for k, (body, report) in enumerate(zip(setup.bodies, reply.bodies, strict=True)):
            own = body.particles
            mass = setup.mass[own]
            self.assertAlmostEqual(report.mass_kg, mass.sum(), delta=1e-15)
            arm = setup.position[own] - mass @ setup.position[own] / mass.sum()
            inertia = mass @ ((arm**2).sum(axis=1) + setup.volume[own] / 6.0)
            self.assertAlmostEqual(report.inertia_kg_m2 / inertia, 1.0, delta=1e-14)
        setup = cantilever()
        (report,) = Server(beam.Beam, 60.0)._open_reply(beam.Beam(setup)).bodies
        self.assertAlmostEqual(report.mass_kg / setup.mass.sum(), 1.0, delta=1e-14)
        self.assertFalse(report.HasField("inertia_kg_m2"))

    def test_open_passes_on_what_a_solver_remarks(self):
        class Doubtful(rigid_body.RigidBodies):
            def remarks(self):
                return ["the mesh is coarse"]

        reply = Server(Doubtful, 60.0)._open_reply(Doubtful(rigid()))
        self.assertEqual(list(reply.remarks), ["the mesh is coarse"])

    def test_the_package_speaks_the_version_of_its_files(self):
        described = Server(rigid_body.RigidBodies, 60.0).Describe(None, None)
        self.assertEqual((described.highest_protocol.major, described.highest_protocol.minor), (2, 0))
        text = (protocol.proto_folder() / "fsi" / "v2" / "types.proto").read_text()
        self.assertIn(f"This file describes {protocol.MAJOR}.{protocol.MINOR}.", text)


if __name__ == "__main__":
    unittest.main()
