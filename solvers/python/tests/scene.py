"""Set-ups, and a fluid that exerts random forces: a whole run of a solver without a server."""

import threading

import numpy as np

from tidelock import Setup, protocol
from tidelock.clock import StageTime
from tidelock.driver import NO_MORE, Run
from tidelock.frames import Sums, digest

SPACING = 0.01
STEP = 1e-3


def lattice(columns, rows, corner, angle=0.0):
    """Positions of a block of particles, rotated about its corner [rad]."""
    x, y = np.meshgrid(np.arange(columns) + 0.5, np.arange(rows) + 0.5)
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array(corner) + SPACING * np.c_[x.ravel(), y.ravel()] @ np.array([[cos, sin], [-sin, cos]])


def spatial_lattice(counts, corner):
    """Positions of a block of particles in space."""
    x, y, z = np.meshgrid(*(np.arange(count) + 0.5 for count in counts))
    return np.array(corner) + SPACING * np.c_[x.ravel(), y.ravel(), z.ravel()]


def setup(blocks, formulation="rigid", held=None, velocity=None, gravity=(0.7, -9.81, 0.4), implicit=False, steps=50):
    """A Setup of bodies with particles at `blocks`, of which those with index in `held` are clamped."""
    message = protocol.setup.SolidSetup(particle_spacing_m=SPACING)
    run, dimensions = message.run, blocks[0].shape[1]
    run.run_id, run.dimensions = "test", dimensions
    run.domain.lower_m.components[:] = (-0.3, -0.5, -0.2)[:dimensions]
    run.domain.upper_m.components[:] = (0.8, 0.6, 0.5)[:dimensions]
    run.body_force.gravity_m_per_s2.components[:] = gravity[:dimensions]
    run.time.start_time_s, run.time.end_time_s, run.time.fixed.time_step_s = 0.0, steps * STEP, STEP
    run.ledger.action, run.ledger.balance_tolerance = protocol.setup.BREACH_ACTION_STOP, 1e-12
    coupling = run.coupling
    coupling.law, coupling.kind = protocol.setup.INTERFACE_LAW_WALL, protocol.types.COUPLING_KIND_LOADS
    coupling.margin_m = 0.005
    coupling.fluid.add(name="kernel_ratio", number=1.3)
    coupling.fluid.add(name="particle_spacing_m", number=0.01)
    if implicit:
        coupling.implicit.tolerance, coupling.implicit.limit = 1e-9, 3
        coupling.implicit.non_convergence = protocol.setup.NON_CONVERGENCE_ACCEPT
    for k in range(len(blocks)):
        body = message.bodies.add(name=f"body {k}", formulation=formulation)
        body.material.add(name="bulk_modulus_pa", number=2e6)
        body.material.add(name="shear_modulus_pa", number=1e6)
        if held is not None:
            body.supports.add(name="clamp").held.components[:] = (True, False)
    places = np.concatenate(blocks)
    count = len(places)
    supports = np.zeros(count, "<u4")
    supports[[] if held is None else held] = 1
    density = 600.0 + 200.0 * np.sin(np.arange(count))
    particles = message.particles
    particles.ids = np.arange(count, dtype="<u4").tobytes()
    particles.bodies = np.repeat(np.arange(len(blocks), dtype="<u4"), [len(block) for block in blocks]).tobytes()
    particles.supports = supports.tobytes()
    particles.masses_kg = (density * SPACING**dimensions).tobytes()
    particles.densities_kg_per_m3 = density.tobytes()
    particles.reference_positions_m = particles.positions_m = places.tobytes()
    particles.velocities_m_per_s = (np.zeros((count, dimensions)) if velocity is None else velocity).tobytes()
    return Setup(message)


class Played:
    """A run of `solver` to its end, in which the fluid exerts random forces of up to `strength` on each point.

    They are some hundred N/m in all in the plane.
    """

    def __init__(self, solver, strength=3.0):
        self.dimensions, self.strength = solver.setup.dimensions, strength
        link = protocol.participant.LinkRequest(run_id="test", first_limit_s=1.0)
        link.partner_extent.version = 1
        self.run, self.solver = Run(solver, link), solver
        self.frames, self.random = [], np.random.default_rng(5)
        self.run.command(protocol.participant.Command(run_id="test", grant_through=10**6))
        fluid = threading.Thread(target=self._fluid, daemon=True)
        fluid.start()
        self.run.run()
        fluid.join(10.0)
        events = list(iter(self.run.events.get_nowait, NO_MORE))
        errors = [event for event in events if isinstance(event, Exception)]
        if errors:
            raise errors[0]
        self.reports = [event.step for event in events if event.HasField("step")]
        self.last = events[-1]

    def _fluid(self):
        previous, sums = protocol.peer.PreviousStage(), None
        while (frame := self.run.outbound.get()) is not NO_MORE:
            if frame.HasField("farewell") or frame.HasField("acceptance"):
                continue
            if frame.iteration == 0:
                self.frames.append(frame)
                if sums is not None:
                    previous.at.step, previous.at.stage = self.frames[-2].step, self.frames[-2].stage
                    sums.write(previous.sums)
            position, velocity = arrays(frame, self.dimensions)
            forces = self.random.uniform(-self.strength, self.strength, position.shape)
            answer = protocol.peer.Frame(
                run_id="test", step=frame.step, stage=frame.stage, iteration=frame.iteration,
                step_start_s_bits=frame.step_start_s_bits, time_step_s_bits=frame.time_step_s_bits, set_version=1,
                count=len(forces), time_step_limit_s=1.0)
            data = forces.tobytes()
            answer.blocks.add(field=protocol.types.FIELD_FORCE, components=self.dimensions, data=data)
            answer.digest = digest(StageTime(frame.step, frame.stage, 0.0, STEP), [], answer.blocks)
            if len(self.frames) > 1:
                answer.previous.CopyFrom(previous)
            previous.used_digest = frame.digest
            sums = Sums.of(-forces, position, velocity, self.solver.setup.origin)
            self.run.inbound.put(answer)

    def stages(self):
        """Half-steps in order: their time as text, and their StageBudget."""
        for report in self.reports:
            yield f"step {report.step} predictor", report.predictor
            yield f"step {report.step} corrector", report.corrector


def arrays(frame, dimensions=2):
    """Positions and velocities in a frame of coupling points."""
    blocks = {block.field: np.frombuffer(block.data, "<f8").reshape(-1, block.components) for block in frame.blocks}
    position, velocity = blocks[protocol.types.FIELD_POSITION], blocks[protocol.types.FIELD_VELOCITY]
    assert position.shape[1] == velocity.shape[1] == dimensions
    return position, velocity


def residual(budget):
    """Residual of the check of the angular momentum over its gross, as StageBudget defines it."""
    torques = sum(np.array(entry.torque_n_m.components) for entry in budget.accounts)
    change = budget.duration_s * (np.array(budget.interface.torque_n_m.components) + torques)
    off = np.linalg.norm(budget.angular.change_kg_m2_per_s.components - change)
    return off / budget.angular.gross_kg_m2_per_s


def torque(budget, account):
    """Torque of an account of a StageBudget about z [N m]."""
    return sum(entry.torque_n_m.components[2] for entry in budget.accounts if entry.account == account)
