"""Vectors of the plane and of space, one row each. Angular quantities are numbers in the plane, vectors in space."""

import numpy as np

# Components of a symmetric tensor in space, in the order of the protocol.
TENSOR = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)]


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a x b of each row."""
    if a.shape[1] == 3:
        return np.cross(a, b)
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def spin_cross(spin: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """spin x arm of each row."""
    if arm.shape[1] == 3:
        return np.cross(spin, arm)
    return np.array([-spin * arm[:, 1], spin * arm[:, 0]]).T


def lifted(vector) -> np.ndarray:
    """The three components of a force or momentum in sums: z is 0 in the plane."""
    return np.concatenate([vector, np.zeros(3 - len(vector))])


def axial(value) -> np.ndarray:
    """The three components of a torque or angular momentum in sums: along z in the plane."""
    value = np.atleast_1d(value)
    return np.concatenate([np.zeros(3 - len(value)), value])


def sums(body: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    """Sums over the particles of each of `count` bodies of numbers, vectors or tensors."""
    columns = values.reshape(len(values), -1).T
    summed = np.array([np.bincount(body, column, count) for column in columns]).T
    return summed.reshape(count, *values.shape[1:])


def point_inertia(mass: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Moment of inertia of points at `arm` [m]: m |r|^2 in the plane, m (|r|^2 1 - r r^T) in space."""
    square = (arm**2).sum(axis=1)
    if arm.shape[1] == 2:
        return mass * square
    return mass[:, None, None] * (square[:, None, None] * np.eye(3) - arm[:, :, None] * arm[:, None, :])


def spin_of(moment: np.ndarray, inertia: np.ndarray, least: np.ndarray) -> np.ndarray:
    """The spin of each body with the angular momentum `moment`; none about axes of no more inertia than `least`."""
    if inertia.ndim == 1:
        turns = inertia > least
        return np.where(turns, moment / np.where(turns, inertia, 1.0), 0.0)
    values, axes = np.linalg.eigh(inertia)
    turns = values > least[:, None]
    inverse = np.where(turns, 1.0 / np.where(turns, values, 1.0), 0.0)
    return np.einsum("kij,kj,klj,kl->ki", axes, inverse, axes, moment)
