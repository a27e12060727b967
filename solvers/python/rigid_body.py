#!/usr/bin/env python3
"""Rigid bodies in the plane with force coupling: three degrees of freedom for each body of the case.

Mass, centre and moment of inertia are those of the particles of the set-up, which are fixed in their body and are its
coupling points. Bodies interact with the fluid only: neither with walls nor with each other.
"""

import numpy as np

from tidelock import Refused, Solver, StageBudget, main

# Columns of a state, one row for each body: centre [m], angle [rad], velocity [m/s], angular velocity [rad/s].
X, ANGLE, V, SPIN = slice(0, 2), 2, slice(3, 5), 5


class RigidBodies(Solver):
    """Serves rigid bodies."""

    name, version = "python-rigid-body", "1"

    def __init__(self, setup):
        super().__init__(setup)
        held = [body.name for body in setup.bodies if (setup.support[body.particles] > 0).any()]
        if held:
            raise Refused([f"`open.solid.bodies`: {held} have supports; rigid bodies of this solver move freely"])
        if not setup.bodies:
            raise Refused(["`open.solid.bodies`: is empty, must hold a body"])
        self.total = np.bincount(setup.body, setup.mass)
        self.state = np.zeros((len(setup.bodies), 6))
        self.state[:, X] = self._mean(setup.position)
        self.arms = setup.position - self.state[setup.body, X]
        # A lattice square of mass m and edge d has the inertia m d²/6 about its own centre.
        own = setup.mass * (self.arms**2).sum(axis=1) + setup.mass * setup.volume / 6.0
        self.inertia = np.bincount(setup.body, own)
        self.state[:, V] = self._mean(setup.velocity)
        slip = setup.velocity - self.state[setup.body, V]
        # RIGID BODIES of setup.proto: preserves a rigid rotation; a single particle has none.
        spread = np.bincount(setup.body, setup.mass * (self.arms**2).sum(axis=1))
        turning = np.bincount(setup.body, setup.mass * _cross(self.arms, slip))
        np.divide(turning, spread, out=self.state[:, SPIN], where=spread > 1e-9 * self.inertia)

    def _mean(self, values):
        sums = [np.bincount(self.body, self.mass * column) for column in values.T]
        return np.array(sums).T / self.total[:, None]

    def _arms(self, state):
        angle = state[self.body, ANGLE]
        cos, sin = np.cos(angle), np.sin(angle)
        x, y = self.arms.T
        return np.array([cos * x - sin * y, sin * x + cos * y]).T

    def kinematics(self, state):
        arms, spin = self._arms(state), state[self.body, SPIN]
        turning = np.array([-spin * arms[:, 1], spin * arms[:, 0]]).T
        return state[self.body, X] + arms, state[self.body, V] + turning

    def body_masses(self):
        return self.total

    def body_inertias(self):
        return self.inertia

    def momentum(self, state):
        return self.total @ state[:, V]

    def advance(self, start, stage, forces, time):
        """Eq. (30)-(31): from the start by the rates of the stage state."""
        force = np.array([np.bincount(self.body, column) for column in forces.T]).T
        force = force + self.total[:, None] * self.setup.gravity
        torque = np.bincount(self.body, _cross(self._arms(stage), forces))
        rates = np.empty_like(start)
        rates[:, X], rates[:, ANGLE] = stage[:, V], stage[:, SPIN]
        rates[:, V], rates[:, SPIN] = force / self.total[:, None], torque / self.inertia
        state = start + time.duration * rates
        weight = self.total.sum() * self.setup.gravity
        gross = np.linalg.norm(weight) + np.linalg.norm(forces, axis=1).sum()
        return state, StageBudget(self.momentum(state), body_force=weight, gross=gross)

    def energies(self, state):
        kinetic = 0.5 * self.total @ (state[:, V] ** 2).sum(axis=1) + 0.5 * self.inertia @ state[:, SPIN] ** 2
        return kinetic, -self.total @ (state[:, X] @ self.setup.gravity), 0.0

    def angle(self, state, body):
        return state[body, ANGLE], state[body, SPIN]


def _cross(a, b):
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


if __name__ == "__main__":
    main(RigidBodies)
