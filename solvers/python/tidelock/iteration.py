"""IMPLICIT COUPLING of peer.proto: relaxation of the forces on the coupling points of each body until they converge."""

import numpy as np

from . import protocol

FIRST_FACTOR, SMALLEST_FACTOR = 1.0, 1e-3


class Iteration:
    """The iterations of the half-steps, by `ImplicitCoupling` of the set-up."""

    def __init__(self, plan, body: np.ndarray):
        self.factor = plan.factor if plan.HasField("factor") else None
        self.tolerance, self.limit = plan.tolerance, plan.limit
        self.accepts_last = plan.non_convergence == protocol.setup.NON_CONVERGENCE_ACCEPT
        self.body, self.count = body, int(body.max()) + 1

    def _sums(self, values: np.ndarray) -> np.ndarray:
        return np.bincount(self.body, values, self.count)

    def begin(self, forces: np.ndarray) -> None:
        """Begins a step whose predictor moved the points with `forces`."""
        self.applied, self.residual = forces, None
        self.scale = self._sums(np.linalg.norm(forces, axis=1))
        self.factors = np.full(self.count, FIRST_FACTOR if self.factor is None else self.factor)

    def compare(self, forces: np.ndarray) -> float:
        """Takes the received forces; returns the largest residual of a body relative to its largest gross force."""
        residual, before = forces - self.applied, self.residual
        if before is not None and self.factor is None:
            along = self._sums((before * (residual - before)).sum(axis=1))
            square = self._sums(((residual - before) ** 2).sum(axis=1))
            aitken = -self.factors * along / np.where(square > 0, square, 1.0)
            self.factors = np.where(square > 0, np.clip(aitken, SMALLEST_FACTOR, 1.0), self.factors)
        self.residual = residual
        self.scale = np.maximum(self.scale, self._sums(np.linalg.norm(forces, axis=1)))
        off = self._sums(np.linalg.norm(residual, axis=1))
        return float((off / np.where(off > 0, self.scale, 1.0)).max())

    def relaxed(self) -> np.ndarray:
        """Forces that move the points in the next iteration."""
        self.applied = self.applied + self.factors[self.body][:, None] * self.residual
        return self.applied
