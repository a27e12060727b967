#!/usr/bin/env python3
"""Rigid bodies with force coupling: three degrees of freedom for each body of the case in the plane, six in space.

Mass, centre and moment of inertia are those of the particles of the set-up, which are fixed in their body and are its
coupling points. Bodies interact with the fluid only: neither with walls nor with each other.
"""

import numpy as np

from tidelock import Refused, Solver, StageBudget, main
from tidelock.vectors import cross, point_inertia, spin_cross, spin_of, sums

# Columns of a state in the plane, one row for each body: centre [m], angle [rad], velocity [m/s], angular velocity [rad/s].
X, ANGLE, V, SPIN = slice(0, 2), 2, slice(3, 5), 5


class RigidBodies(Solver):
    """Serves rigid bodies."""

    name, version = "python-rigid-body", "2"
    dimensions = (2, 3)
    centre, velocity, columns = X, V, 6

    def __new__(cls, setup):
        return super().__new__(SpatialBodies if cls is RigidBodies and setup.dimensions == 3 else cls)

    def __init__(self, setup):
        super().__init__(setup)
        held = [body.name for body in setup.bodies if (setup.support[body.particles] > 0).any()]
        if held:
            raise Refused([f"`open.solid.bodies`: {held} have supports; rigid bodies of this solver move freely"])
        if not setup.bodies:
            raise Refused(["`open.solid.bodies`: is empty, must hold a body"])
        self.total = self._sums(setup.mass)
        self.state = np.zeros((len(setup.bodies), self.columns))
        self.state[:, self.centre] = self._mean(setup.position)
        self.arms = setup.position - self.state[setup.body, self.centre]
        self.state[:, self.velocity] = self._mean(setup.velocity)
        # RIGID BODIES of setup.proto: preserves a rigid rotation; a single particle has none.
        of_places, cells = self._sums(point_inertia(setup.mass, self.arms)), self._sums(setup.cell_inertia)
        slip = cross(self.arms, setup.velocity - self.state[setup.body, self.velocity])
        moment = self._sums(setup.mass * slip if slip.ndim == 1 else setup.mass[:, None] * slip)
        self._start(of_places, cells, spin_of(moment, of_places, 1e-9 * cells))

    def _start(self, of_places, cells, spin):
        """Takes the inertia of the particles' places and cells, and the angular velocity of each body."""
        self.inertia = of_places + cells
        self.state[:, SPIN] = spin

    def _sums(self, values):
        return sums(self.body, values, len(self.setup.bodies))

    def _mean(self, values):
        return self._sums(self.mass[:, None] * values) / self.total[:, None]

    def _arms(self, state):
        angle = state[self.body, ANGLE]
        cos, sin = np.cos(angle), np.sin(angle)
        x, y = self.arms.T
        return np.array([cos * x - sin * y, sin * x + cos * y]).T

    def _spin(self, state):
        return state[:, SPIN]

    def kinematics(self, state):
        arms = self._arms(state)
        turning = spin_cross(self._spin(state)[self.body], arms)
        return state[self.body, self.centre] + arms, state[self.body, self.velocity] + turning

    def body_masses(self):
        return self.total

    def body_inertias(self):
        return self.inertia

    def momentum(self, state):
        return self.total @ state[:, self.velocity]

    def advance(self, start, stage, forces, time):
        """Eq. (30)-(31): from the start by the rates of the stage state."""
        force = self._sums(forces) + self.total[:, None] * self.setup.gravity
        torque = self._sums(cross(self._arms(stage), forces))
        rates = np.empty_like(start)
        rates[:, self.centre], rates[:, self.velocity] = stage[:, self.velocity], force / self.total[:, None]
        state = self._turned(start, stage, rates, torque, time.duration)
        weight = self.total.sum() * self.setup.gravity
        gross = np.linalg.norm(weight) + np.linalg.norm(forces, axis=1).sum()
        return state, StageBudget(self.momentum(state), body_force=weight, gross=gross)

    def _turned(self, start, stage, rates, torque, duration):
        """The state after `duration` from `start` by `rates` and those of the rotation."""
        rates[:, ANGLE], rates[:, SPIN] = stage[:, SPIN], torque / self.inertia
        return start + duration * rates

    def energies(self, state):
        kinetic = 0.5 * self.total @ (state[:, self.velocity] ** 2).sum(axis=1) + self._rotational_energy(state)
        return kinetic, -self.total @ (state[:, self.centre] @ self.setup.gravity), 0.0

    def _rotational_energy(self, state):
        return 0.5 * self.inertia @ state[:, SPIN] ** 2

    def angle(self, state, body):
        return state[body, ANGLE], state[body, SPIN]


class SpatialBodies(RigidBodies):
    """Rigid bodies in space.

    A state has for each body: centre [m], rotation since the start as unit quaternion w, x, y, z, velocity [m/s] and
    angular momentum about the centre [kg m^2/s], from which the angular velocity follows by the turned tensor of inertia.
    """

    centre, rotation, velocity, moment, columns = slice(0, 3), slice(3, 7), slice(7, 10), slice(10, 13), 13

    def _start(self, of_places, cells, spin):
        self.inertia = of_places + cells[:, None, None] * np.eye(3)
        self.inverse = np.linalg.inv(self.inertia)
        self.state[:, self.rotation] = [1.0, 0.0, 0.0, 0.0]
        self.state[:, self.moment] = np.einsum("kij,kj->ki", self.inertia, spin)

    def _rotations(self, state):
        """The rotation matrix of each body."""
        w, x, y, z = state[:, self.rotation].T
        rows = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
        return np.moveaxis(np.array(rows), 2, 0)

    def _arms(self, state):
        return np.einsum("nij,nj->ni", self._rotations(state)[self.body], self.arms)

    def _spin(self, state):
        turned = self._rotations(state)
        return np.einsum("kij,kjl,kml,km->ki", turned, self.inverse, turned, state[:, self.moment])

    def _turned(self, start, stage, rates, torque, duration):
        (w, *axis), spin = stage[:, self.rotation].T, self._spin(stage)
        axis = np.array(axis).T
        # The quaternion's rate is half the product of the angular velocity and the quaternion.
        rates[:, 3] = -0.5 * (spin * axis).sum(axis=1)
        rates[:, 4:7] = 0.5 * (w[:, None] * spin + np.cross(spin, axis))
        rates[:, self.moment] = torque
        state = start + duration * rates
        state[:, self.rotation] /= np.linalg.norm(state[:, self.rotation], axis=1)[:, None]
        return state

    def _rotational_energy(self, state):
        return 0.5 * (self._spin(state) * state[:, self.moment]).sum()

    def angle(self, state, body):
        return *state[body, self.rotation], *self._spin(state)[body]


if __name__ == "__main__":
    main(RigidBodies)
