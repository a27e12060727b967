"""Steps a solver: ONE HALF-STEP of peer.proto with the changes of FORCE COUPLING, and the events of participant.proto."""

import queue
import threading
import time as wall
from dataclasses import replace

import numpy as np

from . import protocol
from .budget import AngularBudget, Auditor, PointState
from .clock import CORRECTOR, PREDICTOR, Clock, StageTime, bits
from .frames import Before, Exchange, PeerFault, Sums
from .iteration import Iteration
from .solver import Diverged, StageBudget, Torques, probe_values

MESSAGES = protocol.participant
CHUNK_BYTES = 1 << 20
BEAT_SECONDS = 1.0
NO_MORE = object()


class Aborted(Exception):
    """Aborted by the coordinator."""


class Run:
    """One run: commands in, events and snapshots out, frames through two queues."""

    def __init__(self, solver, link):
        self.solver, self.setup = solver, solver.setup
        run = self.setup.message.run
        self.clock = Clock(run.time, run.outputs, link.first_limit_s)
        self.coupled = self.setup.coupled
        self.exchange = Exchange(self.setup, solver, link.partner_extent) if self.coupled else None
        self.iteration, self.iterations, self.unconverged = None, 0, False
        if self.coupled and run.coupling.HasField("implicit"):
            self.iteration = Iteration(run.coupling.implicit, solver.body)
        self.tolerance = run.ledger.balance_tolerance
        self.stop_at_breach = run.ledger.action == protocol.setup.BREACH_ACTION_STOP
        self.inbound, self.outbound = queue.Queue(), queue.Queue(maxsize=4)
        self.events, self.snapshots = queue.Queue(maxsize=4096), queue.Queue(maxsize=8)
        self.wants_snapshots = False
        self.orders, self.granted, self.stopping, self.aborted = threading.Condition(), 0, False, False
        self.state, self.stage_budget = solver.state, StageBudget(solver.momentum(solver.state))
        self.start_energies = solver.energies(solver.state)
        self.auditor = Auditor(solver)
        self.forces = np.zeros((len(solver.ids), self.setup.dimensions))
        self.before, self.index, self.breaches, self.waited = None, 0, 0, 0.0
        self.phase = MESSAGES.PHASE_WAITING_FOR_GRANT
        self.last_step = self.heard = wall.monotonic()

    # Orders from the coordinator's thread.

    def command(self, order) -> None:
        """Takes a command."""
        kind = order.WhichOneof("order")
        with self.orders:
            self.heard = wall.monotonic()
            if kind == "grant_through":
                self.granted = max(self.granted, order.grant_through)
            elif kind == "stop":
                self.stopping = True
            elif kind == "abort":
                self._give_up()
            self.orders.notify_all()

    def abort(self) -> None:
        """Aborts the run at once."""
        with self.orders:
            self._give_up()
            self.orders.notify_all()

    def _give_up(self) -> None:
        self.aborted = True
        self.inbound.put(NO_MORE)

    def asked(self) -> float:
        """Time since which the run has waited for the coordinator, which may be suspended; now if it does not wait."""
        with self.orders:
            return self.heard if self.phase == MESSAGES.PHASE_WAITING_FOR_GRANT else wall.monotonic()

    def beat(self):
        """A heartbeat."""
        event = MESSAGES.Event()
        event.beat.step, event.beat.phase = self.clock.step, self.phase
        event.beat.since_last_step_s = wall.monotonic() - self.last_step
        return event

    # The compute thread.

    def run(self) -> None:
        """Runs to the end; the last event is Finished or Failed."""
        try:
            reason = self._steps()
        except Exception as error:  # a defect of the solver ends the run, not the server
            reason = f"the solver failed: {error!r}"
            self.events.put(error)
        if self.coupled:
            self.outbound.put(self.exchange.farewell(reason))
            self.outbound.put(NO_MORE)
        self.events.put(NO_MORE)
        self.snapshots.put(NO_MORE)

    def _steps(self) -> str:
        clock, at = self.clock, self.clock.stage(PREDICTOR)
        try:
            while True:
                self._outputs(clock.due())
                if clock.finished() or not self._may_step():
                    break
                at = clock.stage(PREDICTOR)
                self._step()
            if not clock.finished():
                self._outputs({"probes"})
        except (PeerFault, Diverged, Aborted) as fault:
            self._failed(fault, getattr(fault, "half_step", at))
            return f"failed at step {clock.step}: {fault}"
        event = MESSAGES.Event()
        finished = event.finished
        finished.step, finished.time_s_bits, finished.reached_end = clock.step, bits(clock.time), clock.finished()
        self._counts(finished.counts)
        finished.state_index = self._snapshot()
        self.events.put(event)
        return f"finished at step {clock.step}"

    def _may_step(self) -> bool:
        with self.orders:
            self.phase, self.heard = MESSAGES.PHASE_WAITING_FOR_GRANT, wall.monotonic()
            while not self.aborted and not self.stopping and self.granted <= self.clock.step:
                self.orders.wait()
            if self.aborted:
                raise Aborted("aborted by the coordinator")
            self.phase = MESSAGES.PHASE_COMPUTING
            return self.granted > self.clock.step

    def _step(self) -> None:
        began, waited, breaches = wall.monotonic(), self.waited, self.breaches
        event = MESSAGES.Event()
        report = event.step
        report.step, report.time_step_s_bits = self.clock.step, bits(self.clock.time_step)
        start, limit, self.iterations, self.unconverged = self.state, np.inf, 0, False
        for stage, message in [(PREDICTOR, report.predictor), (CORRECTOR, report.corrector)]:
            time = self.clock.stage(stage)
            try:
                self.state, limit = self._half_step(start, self.state, time, message)
            except (PeerFault, Diverged, Aborted) as fault:
                fault.half_step = time
                raise
        self.clock.advance(limit)
        report.end_time_s_bits = bits(self.clock.time)
        now = self.solver.energies(self.state)
        energies = report.energies
        energies.kinetic_j, energies.potential_j, energies.internal_j = now
        for account, value, start in zip(("kinetic", "potential", "strain"), now, self.start_energies):
            report.energy_accounts.add(account=account, value_j=value, start_j=start)
        report.own_interface_particles = len(self.solver.ids) if self.coupled else 0
        report.iterations, report.unconverged = self.iterations, self.unconverged
        report.waited_s, report.breaches = self.waited - waited, self.breaches - breaches
        self.last_step = wall.monotonic()
        report.elapsed_s = self.last_step - began
        self.events.put(event)

    def _half_step(self, start, stage, time: StageTime, message) -> tuple:
        limit = self.solver.time_step_limit(stage)
        sums = Sums(np.zeros(3), 0.0, np.zeros(3), 0.0, np.zeros(3), 0.0, 0)
        if self.coupled:
            points, limit, sums = self._exchange(start, stage, time, limit)
        else:
            points = self._points(stage)
        state, self.stage_budget = self.solver.advance(start, points.state, self.forces, time)
        ends = PointState.of(self.solver, start), PointState.of(self.solver, state)
        budget = self.auditor.budget(ends[0], points, ends[1], self.stage_budget, sums.gross_torque, time.duration)
        self._write_budget(message, sums, ends, budget, time)
        if self.before is not None:
            self.before.momentum = _momentum_report(message)
        return state, limit

    def _points(self, stage) -> PointState:
        points = PointState.of(self.solver, stage)
        if not (np.isfinite(points.position).all() and np.isfinite(points.velocity).all()):
            raise Diverged("position and velocity of the coupling points [m, m/s]", np.nan, "finite values", "take a smaller time step")
        return points

    def _exchange(self, start, stage, time: StageTime, limit: float) -> tuple:
        """Sends the coupling points of the stage state and receives their forces; with implicit coupling until they converge."""
        iteration, iterated = 0, self.iteration is not None and time.stage == CORRECTOR
        while True:
            points = self._points(stage)
            frame = self.exchange.frame(time, points.position, points.velocity, limit, self.before, iteration)
            self.outbound.put(frame)
            self.forces, used, partner_limit = self._receive(time, iteration)
            if not iterated or self._accepts(time, iteration):
                break
            # Recomputes the state at n + 1/2 with the relaxed forces.
            half = replace(time, stage=PREDICTOR)
            stage, _ = self.solver.advance(start, stage, self.iteration.relaxed(), half)
            iteration += 1
        if self.iteration is not None and not iterated:
            self.iteration.begin(self.forces)
        self.iterations = iteration
        sums = Sums.of(self.forces, points.position, points.velocity, self.setup.origin)
        self.before = Before(time, sums, frame.digest, used)
        return points, min(limit, partner_limit), sums

    def _accepts(self, time: StageTime, iteration: int) -> bool:
        plan, residual = self.iteration, self.iteration.compare(self.forces)
        converged = residual <= plan.tolerance
        if not converged and iteration < plan.limit:
            return False
        if not converged and not plan.accepts_last:
            raise Diverged(f"residual of the forces after {plan.limit} iterations of the half-step [-]", residual,
                           f"at most {plan.tolerance:g}, the tolerance of `interface.iterate`",
                           "use a smaller time step, or a higher limit or tolerance")
        self.unconverged = not converged
        self.outbound.put(self.exchange.acceptance(time, iteration, converged, residual))
        return True

    def _receive(self, time: StageTime, iteration: int) -> tuple:
        self.phase, began = MESSAGES.PHASE_WAITING_FOR_PARTNER, wall.monotonic()
        frame = self.inbound.get()
        self.phase = MESSAGES.PHASE_COMPUTING
        self.waited += wall.monotonic() - began
        if self.aborted:
            raise Aborted("aborted by the coordinator")
        if frame is NO_MORE:
            raise PeerFault("lost the partner: its stream ended without a farewell")
        forces, used, limit = self.exchange.read(frame, time, iteration)
        if iteration == 0:
            faults = self.exchange.check_before(frame, self.before, self.tolerance)
            self.breaches += len(faults)
            if faults and self.stop_at_breach:
                raise faults[0]
        return forces, used, limit

    def _write_budget(self, wire, sums: Sums, ends: tuple, budget: AngularBudget | None, time: StageTime) -> None:
        sums.write(wire.interface)
        own, before = self.stage_budget, self.solver.momentum(ends[0].state)
        supports = np.zeros(3) if own.supports is None else own.supports
        torques = Torques() if budget is None else budget.torques
        for account, force, torque in [
            (MESSAGES.ACCOUNT_BODY_FORCE, own.body_force, torques.body_force),
            (MESSAGES.ACCOUNT_SUPPORTS, supports, torques.supports),
            (MESSAGES.ACCOUNT_OWN_FORCES, np.zeros(3), torques.own_forces),
            (MESSAGES.ACCOUNT_TIME_SCHEME, np.zeros(3), torques.time_scheme),
        ]:
            wire.accounts.add(account=account, force_n=protocol.force(force), torque_n_m=protocol.torque(torque))
        wire.duration_s = time.duration
        wire.momentum_change_kg_m_per_s.CopyFrom(protocol.force(own.momentum - before))
        sizes = sum(self.solver.mass @ np.linalg.norm(end.velocity, axis=1) for end in ends)
        wire.gross_momentum_kg_m_per_s = sizes + time.duration * (own.gross + sums.gross_force)
        if budget is not None:
            budget.write(wire.angular)

    # Outputs.

    def _outputs(self, due: set) -> None:
        if "probes" in due:
            event = MESSAGES.Event()
            event.probes.step, event.probes.time_s_bits = self.clock.step, bits(self.clock.time)
            event.probes.values = probe_values(self.solver, self.state, self.forces, self.stage_budget).astype("<f8").tobytes()
            self.events.put(event)
        if "snapshot" in due:
            index = self._snapshot()
            event = MESSAGES.Event()
            taken = event.snapshot
            taken.index, taken.step, taken.time_s_bits = index, self.clock.step, bits(self.clock.time)
            self.events.put(event)

    def _snapshot(self) -> int:
        index, self.index = self.index, self.index + 1
        if not self.wants_snapshots:
            return index
        position, velocity = self.solver.kinematics(self.state)
        force_unit = "N/m" if self.setup.dimensions == 2 else "N"
        fields = [("position", "m", position), ("velocity", "m/s", velocity), ("fluid_force", force_unit, self.forces),
                  ("density", "kg/m3", self.solver.mass / self.solver.volume)]
        first = MESSAGES.SnapshotChunk(run_id=self.setup.run_id)
        header = first.header
        header.index, header.step, header.time_s_bits = index, self.clock.step, bits(self.clock.time)
        header.count = len(self.solver.ids)
        header.group_names.extend(body.name for body in self.setup.bodies)
        data = np.asarray(self.solver.ids, "<u4").tobytes() + np.asarray(self.solver.body, "<u4").tobytes()
        for name, unit, values in fields:
            header.fields.add(name=name, unit=unit, components=1 if values.ndim == 1 else values.shape[1])
            data += np.ascontiguousarray(values, "<f8").tobytes()
        self.snapshots.put(first)
        for k in range(0, len(data), CHUNK_BYTES):
            self.snapshots.put(MESSAGES.SnapshotChunk(run_id=self.setup.run_id, data=data[k : k + CHUNK_BYTES]))
        return index

    def _counts(self, counts) -> None:
        counts.particles = len(self.solver.ids)
        counts.largest_interface = len(self.solver.ids) if self.coupled else 0

    def _failed(self, fault: Exception, at: StageTime) -> None:
        event = MESSAGES.Event()
        failed = event.failed
        failed.step, failed.time_s_bits = self.clock.step, bits(self.clock.time)
        self._counts(failed.counts)
        if isinstance(fault, Aborted):
            failed.fault.aborted.at.step, failed.fault.aborted.at.stage = at.step, at.stage
        elif isinstance(fault, Diverged):
            diverged = failed.fault.diverged
            diverged.at.step, diverged.at.stage = at.step, at.stage
            diverged.quantity, diverged.value = fault.quantity, fault.value
            diverged.allowed, diverged.hint = fault.allowed, fault.hint
        else:
            fault.fill(failed.fault, at)
        failed.state_index = self._snapshot()
        self.events.put(event)


def _momentum_report(message):
    """MomentumReport of a StageBudget message."""
    report = protocol.peer.MomentumReport(gross_kg_m_per_s=message.gross_momentum_kg_m_per_s)
    report.change_kg_m_per_s.CopyFrom(message.momentum_change_kg_m_per_s)
    if message.HasField("angular"):
        report.angular.CopyFrom(message.angular)
    return report
