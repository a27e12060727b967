"""CLOCK RULE of peer.proto: both sides compute the same bits."""

import math
import struct
from dataclasses import dataclass

from . import protocol

PREDICTOR, CORRECTOR = protocol.types.STAGE_PREDICTOR, protocol.types.STAGE_CORRECTOR
STAGE_NAMES = {PREDICTOR: "predictor", CORRECTOR: "corrector"}
# Constants of the CLOCK RULE.
SLACK = 1e-6
STEPS_PER_EXACT_PROBE = 5


def bits(value: float) -> int:
    """The 64 bits of a float."""
    return struct.unpack("<Q", struct.pack("<d", value))[0]


def from_bits(value: int) -> float:
    """The float of 64 bits."""
    return struct.unpack("<d", struct.pack("<Q", value))[0]


@dataclass(frozen=True)
class StageTime:
    """A half-step: step number, stage, start of the step [s], its size [s]."""

    step: int
    stage: int
    start: float
    time_step: float

    @property
    def duration(self) -> float:
        """Time by which the stage advances from the start of the step [s]."""
        return 0.5 * self.time_step if self.stage == PREDICTOR else self.time_step

    @property
    def state_time(self) -> float:
        """Time of the stage state [s]."""
        return self.start if self.stage == PREDICTOR else self.start + 0.5 * self.time_step

    def __str__(self) -> str:
        return f"step {self.step} {STAGE_NAMES[self.stage]}"


class Clock:
    """Steps, step sizes, end and outputs of a run."""

    def __init__(self, plan, outputs, first_limit: float):
        self.step, self.plan = 0, plan
        self.start, self.end = plan.start_time_s, plan.end_time_s
        self.time = self.start
        self.intervals = {
            "probes": outputs.probe_interval_s if outputs.HasField("probe_interval_s") else None,
            "snapshot": outputs.snapshot_interval_s if outputs.HasField("snapshot_interval_s") else None,
        }
        self.snapshot_times = [time - self.start for time in outputs.snapshot_times_s]
        self.exact_times = None
        if plan.WhichOneof("step") == "fixed":
            self.allowed_step = plan.fixed.time_step_s
        else:
            adaptive = plan.adaptive
            self.allowed_step = min(adaptive.factor * first_limit, adaptive.maximum_s)
            if adaptive.HasField("exact"):
                self.exact_times = [*adaptive.exact.times_s, *outputs.snapshot_times_s]
        self.time_step = self._shortened()
        self.counts = dict.fromkeys(self.intervals, -1)
        self.snapshots_passed = 0

    def _elapsed(self) -> float:
        return self.time - self.start + SLACK * self.time_step

    def _next_exact_time(self) -> float:
        if self.exact_times is None:
            return math.inf
        after = self.time + SLACK * self.allowed_step
        found = [time for time in self.exact_times if time > after]
        snapshots, probes = self.intervals["snapshot"], self.intervals["probes"]
        if probes is not None and probes < STEPS_PER_EXACT_PROBE * self.allowed_step:
            probes = None
        for interval in (snapshots, probes):
            if interval is not None:
                count = math.floor((after - self.start) / interval)
                multiples = (self.start + (count + more) * interval for more in range(3))
                found.append(next((time for time in multiples if time > after), math.inf))
        return min(found, default=math.inf)

    def _shortened(self) -> float:
        left = self._next_exact_time() - self.time
        if left == math.inf:
            return self.allowed_step
        steps = max(math.ceil(left / self.allowed_step - SLACK), 1)
        return min(left / steps, self.allowed_step)

    def stage(self, stage: int) -> StageTime:
        """The half-step of `stage` in the current step."""
        return StageTime(self.step, stage, self.time, self.time_step)

    def finished(self) -> bool:
        """Whether the end is reached."""
        return self._elapsed() >= self.end - self.start

    def advance(self, limit: float) -> None:
        """Advances to the next step; `limit` is the smaller of both sides' limits [s]."""
        self.step += 1
        if self.plan.WhichOneof("step") == "fixed":
            self.time = self.start + self.step * self.time_step
        else:
            adaptive = self.plan.adaptive
            reached, mark = self.time + self.time_step, self._next_exact_time()
            self.time = mark if abs(mark - reached) <= SLACK * self.time_step else reached
            wanted = min(adaptive.factor * limit, adaptive.maximum_s)
            self.allowed_step = min(wanted, adaptive.growth * self.allowed_step)
            self.time_step = self._shortened()

    def due(self) -> set:
        """Names of the outputs that are due at the current boundary; call it once per boundary."""
        found = set()
        for name, interval in self.intervals.items():
            count = 0 if interval is None else math.floor(self._elapsed() / interval)
            if self.step == 0 or self.finished() or count > self.counts[name]:
                found.add(name)
            self.counts[name] = count
        passed = sum(0 < time <= self._elapsed() for time in self.snapshot_times)
        if passed > self.snapshots_passed:
            found.add("snapshot")
        self.snapshots_passed = passed
        return found
