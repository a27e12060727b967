"""AngularBudget of types.proto, from the points of a solver and the masses of the set-up."""

from dataclasses import dataclass

import numpy as np

from . import protocol
from .solver import Solver, StageBudget, Torques
from .vectors import cross, point_inertia, spin_of, sums

# Below this fraction of the inertia of its cells, the particles of a body are a point and have no rotation.
POINT = 1e-9


@dataclass
class PointState:
    """A state, and the positions [m] and velocities [m/s] of its points."""

    state: object
    position: np.ndarray
    velocity: np.ndarray

    @classmethod
    def of(cls, solver: Solver, state) -> "PointState":
        """The points of `solver` in `state`."""
        return cls(state, *solver.kinematics(state))


@dataclass
class AngularBudget:
    """Change of the angular momentum in a half-step and the scale of its round-off [kg m^2/s], and its torques."""

    change: np.ndarray
    gross: float
    torques: Torques

    def write(self, wire) -> None:
        """Fills an AngularBudget message."""
        wire.change_kg_m2_per_s.CopyFrom(protocol.torque(self.change))
        wire.gross_kg_m2_per_s = self.gross


class Auditor:
    """Computes the angular budgets of a run.

    For rigid bodies it needs nothing from the solver: their angular momentum follows from the points. With 0, s and 1
    for the start of the step, the state in which the forces act and the end of the half-step,

        x1 x v1 - x0 x v0 = xs x (v1 - v0) + [(x1 - xs) x v1 + (xs - x0) x v0]

    holds for any positions and velocities. With those of a centre of mass, M (v1 - v0) is the impulse of the forces, so
    that the first term is their moment about the torque origin, and the second is the account of the time scheme.

    `Setup` refuses periodic directions, in which there would be no budget.
    """

    def __init__(self, solver: Solver):
        setup = solver.setup
        self.solver, self.origin, self.gravity = solver, setup.origin, setup.gravity
        own_points = np.array_equal(solver.ids, setup.ids) and np.array_equal(solver.body, setup.body)
        inertias = solver.body_inertias()
        moves_rigidly = all(
            body.rigid or inertias is not None and inertias[k] is not None for k, body in enumerate(setup.bodies))
        self.rigid = own_points and moves_rigidly and len(setup.ids) > 0
        # From the set-up, not from attributes of the solver.
        self.body, self.mass = (setup.body, setup.mass) if self.rigid else (solver.body, solver.mass)
        if self.rigid:
            self.cells = self._sums(setup.cell_inertia)
            self.total = self._sums(setup.mass)

    def _sums(self, values: np.ndarray) -> np.ndarray:
        return sums(self.body, values, len(self.solver.setup.bodies))

    def budget(self, start: PointState, stage: PointState, end: PointState, stage_budget: StageBudget,
               gross_torque: float, duration: float):
        """The budget of a half-step in which the points received forces of `gross_torque` [N]; None without a budget."""
        stated = stage_budget.torques
        if self.rigid and (stated is not None or stage_budget.supports is None):
            stated = Torques() if stated is None else stated
            change = self._rigid_angular_momentum(end) - self._rigid_angular_momentum(start)
            torques = self._add_rigid_torques(stated, start, stage, end, duration)
        else:
            before, after = (self.solver.angular_momentum(points.state) for points in (start, end))
            if stated is None or before is None or after is None:
                return None
            change, torques = after - before, stated
        size = np.linalg.norm(stage.position - self.origin, axis=1)
        forces = gross_torque + self.mass @ size * np.linalg.norm(self.gravity) + stated.gross
        gross = self._sum_of_moments(start) + self._sum_of_moments(end) + duration * forces
        return AngularBudget(change, float(gross), torques)

    def _sum_of_moments(self, points: PointState) -> float:
        arm = np.linalg.norm(points.position - self.origin, axis=1)
        return self.mass @ (arm * np.linalg.norm(points.velocity, axis=1))

    def _means(self, values: np.ndarray) -> np.ndarray:
        """Mean of `values` over each body, weighted by mass."""
        return self._sums(self.mass[:, None] * values) / np.where(self.total > 0, self.total, 1.0)[:, None]

    def _rigid_angular_momentum(self, points: PointState):
        """Angular momentum of all particles, and of their cells, which rotate with the body [kg m^2/s]."""
        place = points.position - self.origin
        arm = place - self._means(place)[self.body]
        slip = points.velocity - self._means(points.velocity)[self.body]
        moment = self._sums(_times(self.mass, cross(arm, slip)))
        spin = spin_of(moment, self._sums(point_inertia(self.mass, arm)), POINT * self.cells)
        return self.mass @ cross(place, points.velocity) + self.cells @ spin

    def _add_rigid_torques(self, stated: Torques, start: PointState, stage: PointState, end: PointState,
                           duration: float) -> Torques:
        x0, xs, x1 = (self._means(points.position - self.origin) for points in (start, stage, end))
        v0, v1 = (self._means(points.velocity) for points in (start, end))
        scheme = self.total @ (cross(x1 - xs, v1) + cross(xs - x0, v0)) / duration
        weight = self.total @ cross(xs, np.broadcast_to(self.gravity, xs.shape))
        return Torques(stated.supports, stated.body_force + weight, stated.own_forces, stated.time_scheme + scheme)


def _times(mass: np.ndarray, values: np.ndarray) -> np.ndarray:
    return mass * values if values.ndim == 1 else mass[:, None] * values
