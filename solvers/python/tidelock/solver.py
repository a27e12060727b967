"""The base class of a solver, and the values of its probes."""

from dataclasses import dataclass, field

import numpy as np

from .clock import StageTime
from .setup import Setup
from .vectors import TENSOR, cross


class Diverged(Exception):
    """The simulation diverged: which quantity (with unit), its value, what is allowed, what to do."""

    def __init__(self, quantity: str, value: float, allowed: str, hint: str):
        super().__init__(f"{quantity} = {value}; allowed: {allowed}; {hint}")
        self.quantity, self.value, self.allowed, self.hint = quantity, value, allowed, hint


@dataclass
class Torques:
    """Torques about the centre of the domain, `setup.origin`, that the fluid does not exert, as means over a stage [N m].

    Numbers in the plane, vectors in space.
    A solver with deformable bodies returns all of them, one with rigid bodies those besides weight and time scheme,
    which the package computes. `own_forces` is the torque of forces inside a body, or the remainder of an approximation.
    `time_scheme` is the change of the sum of m (x - x0) x v by the motion of the positions alone
    (ACCOUNT_TIME_SCHEME of participant.proto). `gross` is the sum of the magnitudes of the torques on parts of the body, the scale of round-off.
    """

    supports: float = 0.0
    body_force: float = 0.0
    own_forces: float = 0.0
    time_scheme: float = 0.0
    gross: float = 0.0


@dataclass
class StageBudget:
    """Momentum budget of a stage; all forces [N], in the plane per metre of depth, are means over its duration.

    `momentum` [kg m/s] is that of the new state, summed over the body itself and not from the forces; `gross` [N] is the
    sum of the magnitudes of all forces on parts of the body, the scale of round-off. `supports` is None in a solver
    without supports. Without `torques` there is no budget of the angular momentum, except for rigid bodies without
    supports.
    """

    momentum: np.ndarray
    body_force: np.ndarray = field(default_factory=lambda: np.zeros(3))
    supports: np.ndarray | None = None
    gross: float = 0.0
    torques: Torques | None = None


class Solver:
    """A solid with force coupling: coupling points out, forces in.

    Subclass it, set `name`, and define `__init__`, `kinematics`, `momentum` and `advance`; the rest has defaults. A state
    may have any type, such as an array: the package stores it and passes it back. `advance` must not modify its
    arguments.
    """

    name, version = "solver", "1"
    # Numbers of dimensions of the runs that it takes.
    dimensions = (2,)
    # Whether the same set-up gives the same bits each time.
    deterministic = True

    def __init__(self, setup: Setup):
        """Reads the set-up, or raises `Refused` with all problems.

        Must set `self.state`, the state at the start. The coupling points are the particles of the set-up (`setup.reference` are
        their positions in the undeformed body, `setup.volume` their volumes) unless `self.volume`, `self.ids` and
        `self.body` are set.
        """
        self.setup = setup
        self.ids, self.body, self.volume, self.mass = setup.ids, setup.body, setup.volume, setup.mass
        self.state = None

    def kinematics(self, state) -> tuple:
        """Positions [m] and velocities [m/s] of the coupling points in `state`, one row each."""
        raise NotImplementedError

    def momentum(self, state) -> np.ndarray:
        """Momentum of all bodies in `state` [kg m/s], in the plane per metre of depth."""
        raise NotImplementedError

    def advance(self, start, stage, forces: np.ndarray, time: StageTime) -> tuple:
        """The state after `time.duration` from `start`, and its `StageBudget`.

        `forces` [N] are those of the fluid on the coupling points in the `stage` state, which is `start` in the predictor and
        the predictor's result in the corrector.
        """
        raise NotImplementedError

    def angular_momentum(self, state):
        """Angular momentum about `setup.origin` of all bodies in `state` [kg m^2/s], not from torques; None for no budget.

        A number in the plane, a vector in space.

        Not called for rigid bodies, whose angular momentum the package computes.
        """
        return None

    def remarks(self):
        """What deserves a second look about the start, a list of sentences; shown as warnings and kept in the results."""
        return []

    def body_masses(self):
        """Mass of each body of the set-up [kg] used in the equations of motion."""
        return np.bincount(self.setup.body, self.setup.mass, len(self.setup.bodies))

    def body_inertias(self):
        """Moment of inertia of each body about its centre of mass [kg m^2] used in the equations of motion.

        A number in the plane, in space the tensor at the start, an array of 3 x 3.
        None for a body that is not rigid, or in place of the list when no body is.
        """
        return None

    def time_step_limit(self, state) -> float:
        """Largest stable next step [s]."""
        return np.inf

    def energies(self, state) -> tuple:
        """Kinetic, potential and strain energy [J]."""
        position, velocity = self.kinematics(state)
        kinetic = 0.5 * self.mass @ (velocity**2).sum(axis=1)
        return kinetic, -self.mass @ (position @ self.setup.gravity), 0.0

    def angle(self, state, body: int) -> tuple:
        """Angle of a body [rad] and its rate [rad/s], for probes; in space its quaternion w, x, y, z and its spin x, y, z."""
        return (np.nan,) * (2 if self.setup.dimensions == 2 else 7)

    def stress(self, state, point: np.ndarray) -> tuple:
        """Stress xx, yy, xy, in space xx, yy, zz, xy, yz, xz [Pa], at a point of the undeformed body, for probes."""
        return (np.nan,) * (3 if self.setup.dimensions == 2 else 6)


def probe_values(solver: Solver, state, forces: np.ndarray, budget: StageBudget) -> np.ndarray:
    """All columns of all probes of the set-up, in their order."""
    position, velocity = solver.kinematics(state)
    values = []
    for probe in solver.setup.message.probes:
        kind, arguments = probe.kind, {a.name: getattr(a, a.WhichOneof("value")) for a in probe.arguments}
        body = arguments.get("body")
        own = slice(None) if body is None else solver.body == body
        if kind == "material-point":
            point = np.array(arguments["at_m"].components)
            weights = _weights(solver.setup.reference[own], point, solver.setup.spacing)
            at, speed = weights @ position[own], weights @ velocity[own]
            stress = solver.stress(state, point)
            # Energy needs the material, which a Python solver does not provide.
            values += [*(at - point), *speed, *stress, *_invariants(stress), np.nan]
        elif kind == "body-motion":
            mass = solver.mass[own]
            centre, speed = mass @ position[own] / mass.sum(), mass @ velocity[own] / mass.sum()
            values += [*centre, *speed, *solver.angle(state, body)]
        elif kind == "body-force":
            values += list(forces[own].sum(axis=0))
        elif kind == "support-reaction":
            values += [0.0] * solver.setup.dimensions if budget.supports is None else list(budget.supports)
        elif kind == "body-sums":
            values += _sums(solver, state, position[own], velocity[own], solver.mass[own])
        else:
            values += [np.nan] * len(probe.columns)
    return np.array(values, dtype=float)


def _invariants(stress) -> tuple:
    """Von Mises stress, largest and smallest principal stress [Pa]; the first needs the stress across a plane."""
    if len(stress) == 3:
        xx, yy, xy = stress
        mean, radius = 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy)
        return np.nan, mean + radius, mean - radius
    if not np.isfinite(stress).all():
        return (np.nan,) * 3
    tensor = np.zeros((3, 3))
    for (i, j), value in zip(TENSOR, stress):
        tensor[i, j] = tensor[j, i] = value
    smallest, middle, largest = np.linalg.eigvalsh(tensor)
    squares = (largest - middle) ** 2 + (middle - smallest) ** 2 + (largest - smallest) ** 2
    return np.sqrt(0.5 * squares), largest, smallest


def _weights(reference: np.ndarray, point: np.ndarray, spacing: float) -> np.ndarray:
    """Weights of the coupling points that interpolate a linear field exactly at `point`."""
    distance = np.linalg.norm(reference - point, axis=1)
    near = np.argsort(distance, kind="stable")[:6]
    base = np.c_[np.ones(len(near)), (reference[near] - point) / spacing]
    weights = np.zeros(len(reference))
    weights[near] = np.linalg.pinv(base)[0]
    return weights


def _sums(solver: Solver, state, position, velocity, mass) -> list:
    momentum = mass @ velocity
    angular = np.atleast_1d(mass @ cross(position, velocity))
    centre = mass @ position / mass.sum()
    arm = position - centre
    places = TENSOR if position.shape[1] == 3 else [(0, 0), (1, 1), (0, 1)]
    second = [mass @ (arm[:, i] * arm[:, j]) for i, j in places]
    energies = solver.energies(state)
    return [mass.sum(), *momentum, *angular, *energies, *centre, *(np.array(second) / mass.sum())]
