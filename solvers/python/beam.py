#!/usr/bin/env python3
"""A clamped Euler-Bernoulli beam of linear finite elements with force coupling.

The body of the case defines it: its support marks the clamp, its particles give length, thickness and mass, its
material E' = E/(1 - nu²) of plane strain. Hermite elements carry the deflection w(s) across the axis; a point at
(s, y) moves by w across and -y w' along it. Forces are transferred to the nodes by the transpose of the same shape
functions, so that force, torque and work are preserved. The motion under the forces of a stage is exact in the modes of
the elements, so the beam does not limit the time step. Deflections should stay below a tenth of the length.
"""

import numpy as np

from tidelock import Refused, Solver, StageBudget, Torques, main

ELEMENTS = 24


class Beam(Solver):
    """Serves a cantilever beam."""

    name, version = "python-beam", "1"

    def __init__(self, setup):
        super().__init__(setup)
        held = setup.support > 0
        if len(setup.bodies) != 1 or not held.any() or held.all():
            raise Refused(["`open.solid.bodies`: must be one body with one clamped end"])
        self._measure(setup, held)
        self._assemble(setup, held)
        free = setup.velocity[~held]
        if np.abs(free).max() > 0:
            raise Refused(["`open.solid.particles.velocities_m_per_s`: this beam starts at rest"])
        # Modal deflections and velocities.
        self.state = np.zeros((2, len(self.omega)))

    def _measure(self, setup, held):
        """Axis, clamp and length: the clamp's face is half-way between the last held and the first free row."""
        toward = setup.reference[~held].mean(axis=0) - setup.reference[held].mean(axis=0)
        along = int(np.argmax(np.abs(toward)))
        self.axis = np.zeros(2)
        self.axis[along] = np.sign(toward[along])
        self.across = np.array([-self.axis[1], self.axis[0]])
        s, y = setup.reference @ self.axis, setup.reference @ self.across
        face = 0.5 * (s[held].max() + s[~held].min())
        self.s, self.y = np.where(held, 0.0, s - face), y - 0.5 * (y.max() + y.min())
        # The torque origin from the middle of the clamp's face, along the axis and across.
        self.about = setup.origin @ self.axis - face, setup.origin @ self.across - 0.5 * (y.max() + y.min())
        self.length, self.thickness = (s - face).max() + 0.5 * setup.spacing, np.ptp(y) + setup.spacing

    def _assemble(self, setup, held):
        """Stiffness, consistent mass and modes; entry 2k is the deflection of node k, 2k + 1 its slope."""
        material = setup.bodies[0]
        bulk, shear = material.bulk_modulus, material.shear_modulus
        poisson = (3 * bulk - 2 * shear) / (6 * bulk + 2 * shear)
        young = 2 * shear * (1 + poisson)
        bending = young / (1 - poisson**2) * self.thickness**3 / 12
        self.line_mass = setup.mass[~held].sum() / self.length
        e = self.length / ELEMENTS
        k = bending / e**3 * np.array([[12, 6 * e, -12, 6 * e], [6 * e, 4 * e**2, -6 * e, 2 * e**2],
                                       [-12, -6 * e, 12, -6 * e], [6 * e, 2 * e**2, -6 * e, 4 * e**2]])
        m = self.line_mass * e / 420 * np.array([[156, 22 * e, 54, -13 * e], [22 * e, 4 * e**2, 13 * e, -3 * e**2],
                                                 [54, 13 * e, 156, -22 * e], [-13 * e, -3 * e**2, -22 * e, 4 * e**2]])
        size = 2 * (ELEMENTS + 1)
        self.stiffness, mass = np.zeros((size, size)), np.zeros((size, size))
        weight = np.zeros(size)
        for n in range(ELEMENTS):
            own = slice(2 * n, 2 * n + 4)
            self.stiffness[own, own] += k
            mass[own, own] += m
            weight[own] += self.line_mass * e * np.array([1 / 2, e / 12, 1 / 2, -e / 12])
        # Generalised eigenvectors by the Cholesky factor of the mass: V' M V = 1, V' K V = omega².
        inverse = np.linalg.inv(np.linalg.cholesky(mass[2:, 2:]))
        squares, vectors = np.linalg.eigh(inverse @ self.stiffness[2:, 2:] @ inverse.T)
        self.omega, self.modes = np.sqrt(squares), inverse.T @ vectors
        self.gravity = weight * (setup.gravity @ self.across)
        self.uniform = np.tile([1.0, 0.0], ELEMENTS + 1)
        # Deflections and slopes of the nodes in a rotation about the torque origin.
        self.rotation = np.ones(size)
        self.rotation[::2] = e * np.arange(ELEMENTS + 1) - self.about[0]
        self.mass_matrix = mass
        self._shape_functions(held, e, size)

    def _shape_functions(self, held, e, size):
        """Rows that interpolate deflection and slope of each coupling point from the nodes; held points do not move."""
        self.w, self.slope = np.zeros((len(self.s), size)), np.zeros((len(self.s), size))
        for i in np.flatnonzero(~held):
            n = min(int(self.s[i] / e), ELEMENTS - 1)
            x, own = self.s[i] / e - n, slice(2 * n, 2 * n + 4)
            self.w[i, own] = [1 - 3 * x**2 + 2 * x**3, e * (x - 2 * x**2 + x**3), 3 * x**2 - 2 * x**3, e * (x**3 - x**2)]
            self.slope[i, own] = [(6 * x**2 - 6 * x) / e, 1 - 4 * x + 3 * x**2, (6 * x - 6 * x**2) / e, 3 * x**2 - 2 * x]

    def _nodes(self, modal):
        return np.concatenate([[0.0, 0.0], self.modes @ modal])

    def kinematics(self, state):
        fields = []
        for modal in state:
            nodes = self._nodes(modal)
            fields.append(np.outer(self.w @ nodes, self.across) - np.outer(self.y * (self.slope @ nodes), self.axis))
        return self.setup.reference + fields[0], fields[1]

    def momentum(self, state):
        return self.uniform @ self.mass_matrix @ self._nodes(state[1]) * self.across

    def angular_momentum(self, state):
        """Angular momentum of the linear beam: its mass moves across the axis, at the undeformed positions."""
        return self.rotation @ self.mass_matrix @ self._nodes(state[1])

    def body_masses(self):
        return [self._mass() + self.setup.mass[self.setup.support > 0].sum()]

    def advance(self, start, stage, forces, time):
        load = self.w.T @ (forces @ self.across) - self.slope.T @ (self.y * (forces @ self.axis)) + self.gravity
        still = (self.modes.T @ load[2:]) / self.omega**2
        cos, sin = np.cos(self.omega * time.duration), np.sin(self.omega * time.duration)
        offset, speed = start[0] - still, start[1] / self.omega
        state = np.array([still + cos * offset + sin * speed, self.omega * (cos * speed - sin * offset)])
        # The clamp carries the mean forces of the root node over the stage, and all forces along the axis.
        mean = still + (sin * offset + (1 - cos) * speed) / (self.omega * time.duration)
        change = self._nodes((state[1] - start[1]) / time.duration)
        root, moment = self.stiffness[:2] @ self._nodes(mean) + self.mass_matrix[:2] @ change - load[:2]
        on_held = forces[self.setup.support > 0].sum(axis=0)
        axial = (forces.sum(axis=0) + self._mass() * self.setup.gravity) @ self.axis
        supports = (root - on_held @ self.across) * self.across - axial * self.axis
        gravity = self._mass() * self.setup.gravity
        # Forces of the elements on their nodes, whose sum is the load of the clamp.
        internal = np.abs(self.stiffness * self._nodes(mean)).sum(axis=1)
        gross = internal[::2].sum() + np.linalg.norm(gravity) + np.linalg.norm(forces, axis=1).sum()
        torques = self._torques(stage, forces, root, moment, np.abs(self.rotation) @ internal)
        return state, StageBudget(self.momentum(state), body_force=gravity, supports=supports, gross=gross, torques=torques)

    def _torques(self, stage, forces, root, moment, internal):
        """Torques; `root` and `moment` are force (across) and moment of the clamp, `internal` the scale of round-off.

        A force at (s, y) has the torque (s - s0) times its component across minus (y - y0) times that along the axis
        about the torque origin (s0, y0): `rotation` times its load on the nodes. The clamp carries the axial component in
        the middle of its face, and the forces on held points where they act. In the linear beam forces act at the
        undeformed positions: `own_forces` subtracts the additional torque at the displaced ones.
        """
        held = self.setup.support > 0
        along, across = self.about
        places = self.setup.reference - self.setup.origin
        axial = (forces[~held].sum(axis=0) + self._mass() * self.setup.gravity) @ self.axis
        supports = moment - along * root - across * axial - _cross(places[held], forces[held]).sum()
        weight = self.rotation @ self.gravity + across * self._mass() * (self.setup.gravity @ self.axis)
        moved = self.kinematics(stage)[0] - self.setup.reference
        return Torques(supports, body_force=weight, own_forces=-_cross(moved, forces).sum(), gross=internal)

    def _mass(self):
        return self.line_mass * self.length

    def energies(self, state):
        nodes = self._nodes(state[0])
        potential = -self.gravity @ nodes
        return 0.5 * (state[1] ** 2).sum(), potential, 0.5 * ((self.omega * state[0]) ** 2).sum()


def _cross(a, b):
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


if __name__ == "__main__":
    main(Beam)
