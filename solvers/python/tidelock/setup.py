"""The set-up of a run, checked once."""

import math
from dataclasses import dataclass, field

import numpy as np

from . import protocol

SETUP = protocol.setup


class Refused(Exception):
    """The set-up cannot be run: all problems, each with its place, value and what is allowed."""

    def __init__(self, problems):
        super().__init__("\n".join(problems))


def unpack(data: bytes, count: int | None, components: int, place: str, kind: str = "<f8") -> np.ndarray:
    """Unpacks an array with `components` numbers for each of `count` particles."""
    size = np.dtype(kind).itemsize * components
    if len(data) % size or count is not None and len(data) != count * size:
        wanted = "a multiple of" if count is None else f"{count} x"
        raise Refused([f"`{place}`: has {len(data)} bytes, must have {wanted} {components} numbers x {size // components} bytes"])
    values = np.frombuffer(data, kind)
    if kind == "<f8" and not np.isfinite(values).all():
        bad = int(np.flatnonzero(~np.isfinite(values))[0])
        raise Refused([f"`{place}`: of particle number {bad // components} is {values[bad]}, must be finite"])
    return values.reshape(-1, components) if components > 1 else values


def parameters(messages, place: str, known=None) -> dict:
    """Values of named parameters; a name that is not `known` would change the result and is refused."""
    found = {}
    for message in messages:
        kind = message.WhichOneof("value")
        if kind is None or known is not None and message.name not in known:
            raise Refused([f"`{place}.{message.name}`: is not a parameter that this solver knows"])
        found[message.name] = getattr(message, kind)
    return found


ELASTIC = ("density_kg_m3", "bulk_modulus_pa", "shear_modulus_pa")


@dataclass
class Body:
    """A body: name, elastic constants [Pa], supports, indices of its particles, whether it is rigid."""

    name: str
    bulk_modulus: float
    shear_modulus: float
    supports: list
    particles: np.ndarray
    rigid: bool


@dataclass
class Setup:
    """Set-up of a solid solver, in SI units, in the plane per metre of depth; `message` is the SolidSetup itself.

    Vectors have `dimensions` components.
    """

    message: object
    run_id: str = ""
    dimensions: int = 2
    gravity: np.ndarray = None
    spacing: float = 0.0
    origin: np.ndarray = None
    bodies: list = field(default_factory=list)
    ids: np.ndarray = None
    body: np.ndarray = None
    support: np.ndarray = None
    mass: np.ndarray = None
    volume: np.ndarray = None
    reference: np.ndarray = None
    position: np.ndarray = None
    velocity: np.ndarray = None

    def __post_init__(self):
        problems = self._problems()
        if problems:
            raise Refused(problems)
        run = self.message.run
        self.run_id, self.dimensions = run.run_id, run.dimensions
        self.gravity = np.array(run.body_force.gravity_m_per_s2.components)
        self.spacing = self.message.particle_spacing_m
        # Reference point of torques.
        self.origin = 0.5 * (np.array(run.domain.lower_m.components) + np.array(run.domain.upper_m.components))
        self._read_particles()

    @property
    def cell_inertia(self) -> np.ndarray:
        """Moment of inertia of the cell of each particle about its own centre and any axis, m a^2 / 6 [kg m^2]."""
        return self.mass * self.volume ** (2.0 / self.dimensions) / 6.0

    @property
    def fluid_support(self) -> float:
        """Support radius of the fluid's kernel, 2 h [m]."""
        fluid = parameters(self.message.run.coupling.fluid, "open.solid.run.coupling.fluid")
        return 2.0 * fluid["kernel_ratio"] * fluid["particle_spacing_m"]

    @property
    def coupled(self) -> bool:
        """Whether there is a fluid."""
        return self.message.run.HasField("coupling")

    def _problems(self) -> list:
        message, run = self.message, self.message.run
        found = []

        def check(good, place, problem):
            if not good:
                found.append(f"`open.solid.{place}`: {problem}")

        check(0 < len(run.run_id.encode()) <= protocol.MAX_NAME_BYTES, "run.run_id", "must have 1 to 256 bytes")
        count = run.dimensions
        check(count in (2, 3), "run.dimensions", f"is {count}, must be 2 or 3")
        lower, upper = run.domain.lower_m.components, run.domain.upper_m.components
        for name, values in [("run.domain.lower_m", lower), ("run.domain.upper_m", upper),
                             ("run.body_force.gravity_m_per_s2", run.body_force.gravity_m_per_s2.components)]:
            check(len(values) == count, name, f"has {len(values)} components, must have {count} in a run of {count} dimensions")
            check(all(map(math.isfinite, values)), name, f"is {list(values)}, must be finite")
        for name, value in [("run.time.start_time_s", run.time.start_time_s), ("run.time.end_time_s", run.time.end_time_s)]:
            check(math.isfinite(value), name, f"is {value}, must be finite")
        check(all(a < b for a, b in zip(lower, upper)), "run.domain.upper_m", "must exceed lower_m")
        step = run.time.WhichOneof("step")
        check(step is not None, "run.time.step", "is missing, must be `fixed` or `adaptive`")
        if step == "fixed":
            size = run.time.fixed.time_step_s
            check(0 < size < math.inf, "run.time.fixed.time_step_s", f"is {size}, must be positive and finite")
        warn, stop = SETUP.BREACH_ACTION_WARN, SETUP.BREACH_ACTION_STOP
        check(run.ledger.action in (warn, stop), "run.ledger.action",
              f"is {run.ledger.action}, must be {warn} (warn) or {stop} (stop)")
        check(0 < message.particle_spacing_m < math.inf, "particle_spacing_m",
              f"is {message.particle_spacing_m}, must be positive and finite")
        if run.HasField("coupling"):
            loads = protocol.types.COUPLING_KIND_LOADS
            check(run.coupling.kind == loads, "run.coupling.kind",
                  f"is {run.coupling.kind}, this solver offers {loads} (force coupling)")
            slip, no_slip = protocol.INTERFACE_LAWS
            check(run.coupling.law in (slip, no_slip), "run.coupling.law",
                  f"is {run.coupling.law}, must be {slip} (wall) or {no_slip} (wall-no-slip)")
        # What this package does not offer is refused, not ignored.
        check(not run.body_force.HasField("expressions_m_per_s2"), "run.body_force.expressions_m_per_s2",
              "this solver evaluates no expressions")
        check(not any(run.domain.periodic.components), "run.domain.periodic",
              "this solver knows no periodic directions")
        check(not (message.HasField("damping") and message.damping.rate_per_s > 0), "damping", "is not offered by this solver")
        for k, body in enumerate(message.bodies):
            check(not body.HasField("acceleration_m_per_s2"), f"bodies[{k}].acceleration_m_per_s2",
                  "this solver evaluates no expressions")
            check(not body.loads, f"bodies[{k}].loads", "surface loads are not offered by this solver")
            for support in body.supports:
                check(not support.HasField("motion") and not support.HasField("release_time_s"),
                      f"bodies[{k}].supports", "moving and released supports are not offered by this solver")
        return found

    def _read_particles(self) -> None:
        particles, place = self.message.particles, "open.solid.particles"
        self.ids = unpack(particles.ids, None, 1, f"{place}.ids", "<u4")
        count = len(self.ids)
        problems = []

        def read(name, components=1, kind="<f8", positive=False, below=None):
            try:
                values = unpack(getattr(particles, name), count, components, f"{place}.{name}", kind)
            except Refused as refused:
                problems.append(str(refused))
                return np.zeros((count, components) if components > 1 else count)
            if positive and (values <= 0).any():
                problems.append(f"`{place}.{name}`: must be positive")
            if below is not None and (values >= below).any():
                problems.append(f"`{place}.{name}`: is {values.max()}, must be below {below}")
            return values

        if (np.diff(self.ids.astype(np.int64)) <= 0).any():
            problems.append(f"`{place}.ids`: must ascend strictly")
        self.body = read("bodies", kind="<u4", below=len(self.message.bodies))
        self.support = read("supports", kind="<u4")
        self.mass = read("masses_kg", positive=True)
        density = read("densities_kg_per_m3", positive=True)
        self.reference = read("reference_positions_m", self.dimensions)
        self.position = read("positions_m", self.dimensions)
        self.velocity = read("velocities_m_per_s", self.dimensions)
        if problems:
            raise Refused(problems)
        self.volume = self.mass / density
        for k, body in enumerate(self.message.bodies):
            own = np.flatnonzero(self.body == k)
            material = parameters(body.material, f"open.solid.bodies[{k}].material", ELASTIC)
            _, bulk, shear = (material.get(name, 0.0) for name in ELASTIC)
            rigid = body.formulation == "rigid"
            self.bodies.append(Body(body.name, bulk, shear, list(body.supports), own, rigid))
