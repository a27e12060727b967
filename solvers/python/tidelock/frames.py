"""Half-step frames of a solid with force coupling: FORCE COUPLING, ORDER RULE, DIGEST and BALANCE of peer.proto."""

import struct
import zlib
from dataclasses import dataclass

import numpy as np

from . import protocol
from .clock import PREDICTOR, STAGE_NAMES, StageTime, bits, from_bits
from .vectors import axial, cross, lifted

TYPES, CHECKS = protocol.types, protocol.participant
CHECK_NAMES = {CHECKS.CHECK_FORCE: "force", CHECKS.CHECK_TORQUE: "torque"}


class PeerFault(Exception):
    """The partner's frame was refused; `fill` writes the fault into a Fault message."""

    def fill(self, fault, at: StageTime) -> None:
        """Writes this fault."""
        fault.peer.at.step, fault.peer.at.stage = at.step, at.stage
        fault.peer.message = str(self)[:3000]


class ClockFault(PeerFault):
    """The clocks of the sides differ."""

    def fill(self, fault, at):
        fault.clock.at.step, fault.clock.at.stage = at.step, at.stage
        fault.clock.difference = str(self)


class LedgerFault(PeerFault):
    """The ledger does not balance."""

    def __init__(self, at, check: int, residual: float, tolerance: float):
        super().__init__(f"ledger breach at {at}: {CHECK_NAMES[check]} is off by {residual:.2e} of gross, allowed {tolerance:.0e}")
        self.at, self.check, self.residual, self.tolerance = at, check, residual, tolerance

    def fill(self, fault, at):
        breach = fault.ledger
        breach.at.step, breach.at.stage, breach.check = self.at.step, self.at.stage, self.check
        breach.residual, breach.tolerance = self.residual, self.tolerance


class StaleFault(PeerFault):
    """The partner computed from another frame than the one sent."""

    def __init__(self, at, sent: int, used: int):
        super().__init__(f"stale frame at {at}: sent was {sent:08x}, used {used:08x}")
        self.at, self.sent, self.used = at, sent, used

    def fill(self, fault, at):
        stale = fault.stale_frame
        stale.at.step, stale.at.stage, stale.sent, stale.used = self.at.step, self.at.stage, self.sent, self.used


@dataclass
class Sums:
    """InterfaceSums of the forces on coupling points; vectors have three components."""

    force: np.ndarray
    gross_force: float
    torque: np.ndarray
    gross_torque: float
    couple: np.ndarray
    power: float
    pairs: int

    @classmethod
    def of(cls, forces, position, velocity, origin) -> "Sums":
        """Sums of `forces` that act on coupling points, torques about `origin`."""
        size, arm = np.linalg.norm(forces, axis=1), position - origin
        torque = axial(cross(arm, forces).sum(axis=0))
        return cls(lifted(forces.sum(axis=0)), size.sum(), torque, np.linalg.norm(arm, axis=1) @ size, np.zeros(3),
                   (forces * velocity).sum(), int((size > 0).sum()))

    @classmethod
    def read(cls, wire) -> "Sums":
        """Reads an InterfaceSums message."""
        force, torque, couple = (
            np.array(vector.components) for vector in (wire.force_n, wire.torque_n_m, wire.couple_n_m))
        if not len(force) == len(torque) == len(couple) == 3:
            raise PeerFault("`frame.previous.sums`: vectors must have 3 components")
        return cls(force, wire.gross_force_n, torque, wire.gross_torque_n_m, couple, wire.power_w, wire.pairs)

    def write(self, wire) -> None:
        """Fills an InterfaceSums message."""
        wire.force_n.CopyFrom(protocol.vector(self.force))
        wire.torque_n_m.CopyFrom(protocol.vector(self.torque))
        wire.couple_n_m.CopyFrom(protocol.vector(self.couple))
        wire.gross_force_n, wire.gross_torque_n_m = self.gross_force, self.gross_torque
        wire.power_w, wire.pairs = self.power, self.pairs


@dataclass
class Before:
    """Data of the previous half-step that the next frames check, and its momentum report."""

    at: StageTime
    sums: Sums
    sent: int
    used: int
    momentum: object = None


def _words(time: StageTime) -> bytes:
    return struct.pack("<QQ", time.step, 0 if time.stage == PREDICTOR else 1)


def digest(time: StageTime, ids, blocks) -> int:
    """DIGEST of a frame with `blocks`; `ids` of its particles, none in a frame of forces."""
    value = zlib.crc32(np.asarray(ids, "<u8").tobytes(), zlib.crc32(_words(time)))
    for block in blocks:
        value = zlib.crc32(block.data, value)
    return value


class Exchange:
    """Builds own frames and checks the partner's, one after the other."""

    def __init__(self, setup, solver, partner_extent):
        self.setup, self.solver = setup, solver
        self.partner_extent_version = partner_extent.version
        coupling = setup.message.run.coupling
        self.reach = setup.fluid_support + coupling.margin_m
        self.central = coupling.law == protocol.setup.INTERFACE_LAW_WALL
        self.extent, self.boxes = TYPES.Extent(), None
        self.set_sent, self.epoch, self.last = False, 0, None

    def update_extent(self, position) -> bool:
        """Updates the extent when coupling points have left its box; returns whether it did."""
        slack = self.setup.spacing
        lower, upper = position.min(axis=0), position.max(axis=0)
        if self.boxes is not None and (lower >= self.boxes[0]).all() and (upper <= self.boxes[1]).all():
            return False
        self.boxes = np.array([lower - slack, upper + slack])
        self.extent = TYPES.Extent(version=self.extent.version + 1, boxes_m=self.boxes.astype("<f8").tobytes())
        return True

    def _head(self, time: StageTime, iteration: int, **fields):
        return protocol.peer.Frame(
            run_id=self.setup.run_id, epoch=self.epoch, step=time.step, stage=time.stage, iteration=iteration,
            step_start_s_bits=bits(time.start), time_step_s_bits=bits(time.time_step), **fields,
        )

    def acceptance(self, time: StageTime, iteration: int, converged: bool, residual: float):
        """The frame that ends the iterations of a half-step."""
        frame = self._head(time, iteration)
        frame.acceptance.converged, frame.acceptance.residual = converged, residual
        return frame

    def frame(self, time: StageTime, position, velocity, limit: float, before: Before | None, iteration: int = 0):
        """The own frame of a half-step: all coupling points, which the EXTENT RULE always allows."""
        solver = self.solver
        frame = self._head(
            time, iteration, set_version=1,
            count=len(solver.ids), partner_extent_version=self.partner_extent_version, reach_m=self.reach,
            time_step_limit_s=limit,
        )
        if not self.set_sent:
            self.set_sent = True
            frame.set.ids = np.asarray(solver.ids, "<u4").tobytes()
            frame.set.groups = np.asarray(solver.body, "<u4").tobytes()
        dimensions = self.setup.dimensions
        for field, components, values in [(TYPES.FIELD_POSITION, dimensions, position),
                                          (TYPES.FIELD_VELOCITY, dimensions, velocity),
                                          (TYPES.FIELD_VOLUME, 1, solver.volume)]:
            frame.blocks.add(field=field, components=components, data=np.ascontiguousarray(values, "<f8").tobytes())
        frame.digest = digest(time, solver.ids, frame.blocks)
        if self.update_extent(position):
            frame.extent.CopyFrom(self.extent)
        frame.extent_version = self.extent.version
        if before is not None:
            previous = frame.previous
            previous.at.step, previous.at.stage = before.at.step, before.at.stage
            before.sums.write(previous.sums)
            previous.used_digest = before.used
            if before.momentum is not None:
                previous.momentum.CopyFrom(before.momentum)
        return frame

    def farewell(self, reason: str):
        """The last message of this side."""
        frame = protocol.peer.Frame(run_id=self.setup.run_id, epoch=self.epoch)
        frame.farewell.reason = reason[:1000]
        return frame

    def read(self, frame, time: StageTime, iteration: int = 0) -> tuple:
        """The forces of the partner's frame for `time`, its digest, and its limit for the next step [s]."""
        if frame.ByteSize() > protocol.MAX_FRAME_BYTES:
            raise PeerFault(f"`frame`: has {frame.ByteSize()} bytes, above the size limit of {protocol.MAX_FRAME_BYTES}")
        for name, got, wanted in [("run_id", frame.run_id, self.setup.run_id), ("epoch", frame.epoch, self.epoch)]:
            if got != wanted:
                raise PeerFault(f"`frame.{name}`: is {got!r}, expected {wanted!r}")
        if frame.HasField("farewell"):
            raise PeerFault(f"it ended its run: {frame.farewell.reason}")
        got, wanted = (frame.step, frame.stage, frame.iteration), (time.step, time.stage, iteration)
        if got != wanted or frame.HasField("acceptance"):
            remark = ", which came before: a duplicate" if got == self.last else ""
            stage = STAGE_NAMES.get(frame.stage, frame.stage)
            raise PeerFault(f"`frame`: expected iteration {iteration} of {time}, got iteration {frame.iteration} of "
                            f"step {frame.step} {stage}{remark}")
        for name, ours, theirs in [("start of step", time.start, frame.step_start_s_bits),
                                   ("time step", time.time_step, frame.time_step_s_bits)]:
            if bits(ours) != theirs:
                raise ClockFault(f"{name} [s] is {ours!r} here and {from_bits(theirs)!r} at the partner")
        count = len(self.solver.ids)
        if (frame.count, frame.set_version) != (count, 1):
            raise PeerFault(f"`frame.count`: is {frame.count} for set {frame.set_version}, {count} coupling points of set 1 were sent")
        dimensions = self.setup.dimensions
        if [(block.field, block.components) for block in frame.blocks] != [(TYPES.FIELD_FORCE, dimensions)]:
            raise PeerFault(f"`frame.blocks`: must be the force with {dimensions} components, once")
        data = frame.blocks[0].data
        if len(data) != 8 * dimensions * count:
            raise PeerFault(f"`frame.blocks[0].force`: has {len(data)} bytes, must have {count} particles x {dimensions} numbers x 8 bytes")
        forces = np.frombuffer(data, "<f8").reshape(count, dimensions)
        if not np.isfinite(forces).all():
            bad = int(np.flatnonzero(~np.isfinite(forces).all(axis=1))[0])
            raise PeerFault(f"`frame.blocks[0].force`: of particle number {bad} is {forces[bad]}, NaN or infinite; must be finite")
        used = digest(time, [], frame.blocks)
        if used != frame.digest:
            raise PeerFault(f"`frame.digest`: is {frame.digest:08x}, but the data have {used:08x} (DATA_LOSS)")
        if not frame.time_step_limit_s > 0:
            raise PeerFault(f"`frame.time_step_limit_s`: is {frame.time_step_limit_s}, must be positive")
        if frame.HasField("extent"):
            self.partner_extent_version = frame.extent.version
        self.last = (frame.step, frame.stage, frame.iteration)
        return forces, used, frame.time_step_limit_s

    def check_before(self, frame, before: Before | None, tolerance: float) -> list:
        """Faults found in the partner's report of the previous half-step."""
        if before is None:
            return []
        theirs = frame.previous
        if (theirs.at.step, theirs.at.stage) != (before.at.step, before.at.stage):
            raise PeerFault(f"the frame lacks the sums of {before.at}")
        faults = []
        if theirs.used_digest != before.sent:
            faults.append(StaleFault(before.at, before.sent, theirs.used_digest))
        own, partner = before.sums, Sums.read(theirs.sums)
        net = own.torque + partner.torque - (0.0 if self.central else 2.0 * partner.couple)
        checks = [(CHECKS.CHECK_FORCE, np.linalg.norm(own.force + partner.force), max(own.gross_force, partner.gross_force)),
                  (CHECKS.CHECK_TORQUE, np.linalg.norm(net), max(own.gross_torque, partner.gross_torque))]
        for check, residual, gross in checks:
            if not residual <= tolerance * gross:
                faults.append(LedgerFault(before.at, check, residual / gross if gross else np.inf, tolerance))
        return faults
