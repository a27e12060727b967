"""AngularBudget of participant.proto, from what a solver shows and the masses of the set-up."""

from dataclasses import dataclass

import numpy as np

from .solver import Books, Solver, Torques

# A body whose particles all lie at its centre to this part of their cells' inertia shows no turning.
POINT = 1e-9


@dataclass
class Shown:
    """A state, and the positions [m] and velocities [m/s] of the samples that the solver shows of it."""

    state: object
    position: np.ndarray
    velocity: np.ndarray

    @classmethod
    def of(cls, solver: Solver, state) -> "Shown":
        """What `solver` shows of `state`."""
        return cls(state, *solver.kinematics(state))


@dataclass
class Budget:
    """Change of the angular momentum in a half-step and the scale of its round-off [kg m/s], and its torques."""

    change: float
    gross: float
    torques: Torques

    def write(self, wire) -> None:
        """Fills an AngularBudget message."""
        own, torques = self.torques, wire.torques
        for name in torques.DESCRIPTOR.fields_by_name:
            setattr(torques, name, float(getattr(own, name.removesuffix("_n"), 0.0)))
        wire.angular_momentum_change_kg_m_per_s = self.change
        wire.gross_angular_momentum_kg_m_per_s = self.gross


class Auditor:
    """Makes the budgets of a run.

    Of rigid bodies it needs no word of the solver: their angular momentum follows from the shown samples. With 0, s and 1
    for the start of the step, the state in which the forces act and the end of the half-step,

        x1 x v1 - x0 x v0 = xs x (v1 - v0) + [(x1 - xs) x v1 + (xs - x0) x v0]

    holds for any places and velocities. With those of a centre of mass, M (v1 - v0) is the impulse of the forces, so that
    the first term is their moment about the torque origin, and the second is the account of the time scheme.

    `Setup` refuses periodic directions, in which there would be no budget.
    """

    def __init__(self, solver: Solver):
        setup = solver.setup
        self.solver, self.origin, self.gravity = solver, setup.origin, setup.gravity
        own_samples = np.array_equal(solver.ids, setup.ids) and np.array_equal(solver.body, setup.body)
        inertias = solver.body_inertias()
        moves_rigidly = all(
            body.rigid or inertias is not None and inertias[k] is not None for k, body in enumerate(setup.bodies))
        self.rigid = own_samples and moves_rigidly and len(setup.ids) > 0
        # The set-up's, not attributes of the solver.
        self.body, self.mass = (setup.body, setup.mass) if self.rigid else (solver.body, solver.mass)
        if self.rigid:
            self.cells = self._sums(setup.mass * setup.volume / 6.0)
            self.total = self._sums(setup.mass)

    def _sums(self, values: np.ndarray) -> np.ndarray:
        return np.bincount(self.body, values, len(self.solver.setup.bodies))

    def budget(self, start: Shown, stage: Shown, end: Shown, books: Books, gross_torque: float, duration: float):
        """The budget of a half-step, in which samples received forces of `gross_torque` [N]; None without one."""
        stated = books.torques
        if self.rigid and (stated is not None or books.supports is None):
            stated = Torques() if stated is None else stated
            change = self._rigid_angular_momentum(end) - self._rigid_angular_momentum(start)
            torques = self._add_rigid_torques(stated, start, stage, end, duration)
        else:
            before, after = (self.solver.angular_momentum(shown.state) for shown in (start, end))
            if stated is None or before is None or after is None:
                return None
            change, torques = after - before, stated
        size = np.linalg.norm(stage.position - self.origin, axis=1)
        forces = gross_torque + self.mass @ size * np.linalg.norm(self.gravity) + stated.gross
        gross = self._sum_of_moments(start) + self._sum_of_moments(end) + duration * forces
        return Budget(float(change), float(gross), torques)

    def _sum_of_moments(self, shown: Shown) -> float:
        arm = np.linalg.norm(shown.position - self.origin, axis=1)
        return self.mass @ (arm * np.linalg.norm(shown.velocity, axis=1))

    def _means(self, values: np.ndarray) -> np.ndarray:
        """Mean of `values` over each body, weighted by mass."""
        sums = np.array([self._sums(self.mass * column) for column in values.T])
        return sums.T / np.where(self.total > 0, self.total, 1.0)[:, None]

    def _rigid_angular_momentum(self, shown: Shown) -> float:
        """That of all particles, and of their cells about their own centres, which turn with the body [kg m/s]."""
        place = shown.position - self.origin
        arm = place - self._means(place)[self.body]
        slip = shown.velocity - self._means(shown.velocity)[self.body]
        spread = self._sums(self.mass * (arm**2).sum(axis=1))
        turns = spread > POINT * self.cells
        spin = np.where(turns, self._sums(self.mass * _cross(arm, slip)) / np.where(turns, spread, 1.0), 0.0)
        return self.mass @ _cross(place, shown.velocity) + self.cells @ spin

    def _add_rigid_torques(self, stated: Torques, start: Shown, stage: Shown, end: Shown, duration: float) -> Torques:
        x0, xs, x1 = (self._means(shown.position - self.origin) for shown in (start, stage, end))
        v0, v1 = (self._means(shown.velocity) for shown in (start, end))
        scheme = self.total @ (_cross(x1 - xs, v1) + _cross(xs - x0, v0)) / duration
        weight = self.total @ _cross(xs, np.broadcast_to(self.gravity, xs.shape))
        return Torques(stated.supports, stated.body_force + weight, stated.own_forces, stated.time_scheme + scheme)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
