"""Predictions of observations, as functions of the unknown fields and of the wear coefficient.

Wear depends on the product of the wear coefficient k and the meshes N: one run at a fixed k over rising meshes gives
the prediction for every k N. So runs are made at values of the other fields only, and each gives all wear states.
Over the wear states predictions are interpolated by cubic splines. Over the fields they are emulated: predicted
values of an observation are sums of a few shapes (singular value decomposition, without the movements of a datum),
the amounts of all observations in all wear states are sums of a few components, and each component is a Gaussian
process (Higdon et al. 2008, J. Am. Stat. Assoc. 103, 570-583).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline

from semiwear.arrays import FloatArray
from semiwear.emulator import Emulator, emulator_of
from semiwear.inference.observations import Channel

_MOST_SHAPES, _MOST_COMPONENTS = 12, 16
_LEFT = 1e-3  # of the root mean square: remainder of predictions beside the shapes
_LEFT_OF_AMOUNTS = 3e-4


@dataclass(frozen=True)
class Runs:
    """Predictions of runs.

    Attributes
    ----------
    inputs : (run, field) array
        Places within the ranges of the fields, -1 to 1.
    levels : (state,) array
        Meshes of the wear states at the scene's wear coefficient, from 0.
    values : tuple of (run, state, places) arrays
        One for each channel.
    """

    inputs: FloatArray
    levels: FloatArray
    values: tuple[FloatArray, ...]

    def joined(self, other: Runs) -> Runs:
        """These runs and others."""
        values = tuple(np.concatenate(pair) for pair in zip(self.values, other.values, strict=True))
        return Runs(np.concatenate([self.inputs, other.inputs]), self.levels, values)


@dataclass(frozen=True)
class Model:
    """Amounts of the shapes of every channel, as functions of fields and of k N.

    Attributes
    ----------
    runs : Runs
    shapes : tuple of (places, shapes) arrays
        One for each channel, orthonormal.
    emulators : tuple of Emulator
        One for each component; empty if a single run determines everything.
    components : (components, states * amounts) array
    mean : (states * amounts,) array
    left_out : (run, state, amounts) array
        True less emulated amounts, with each run left out in turn.
    """

    runs: Runs
    shapes: tuple[FloatArray, ...]
    emulators: tuple[Emulator, ...]
    components: FloatArray
    mean: FloatArray
    left_out: FloatArray

    @cached_property
    def parts(self) -> list[slice]:
        """Slice of each channel's amounts among all."""
        ends = np.cumsum([0, *(basis.shape[1] for basis in self.shapes)])
        return [slice(int(low), int(high)) for low, high in pairwise(ends)]

    def amounts(self, inputs: FloatArray, meshes: FloatArray) -> list[FloatArray]:
        """Amounts of each channel's shapes.

        Parameters
        ----------
        inputs : (point, field) array
        meshes : (point, channel) array
            Meshes at the scene's wear coefficient.

        Returns
        -------
        list of (point, shapes) arrays
        """
        if self.emulators:
            scores = np.stack([emulator.at(inputs) for emulator in self.emulators], axis=1)
            whole = self.mean + scores @ self.components
        else:
            whole = np.broadcast_to(self.mean, (inputs.shape[0], self.mean.size))
        states = whole.reshape(inputs.shape[0], self.runs.levels.size, -1)
        return [
            np.asarray(np.einsum("ps,psa->pa", self.weights(meshes[:, k]), states[..., part]))
            for k, part in enumerate(self.parts)
        ]

    def weights(self, meshes: FloatArray) -> FloatArray:
        """Interpolation weights of all wear states, (point, state)."""
        if self.runs.levels.size == 1:
            return np.ones((np.size(meshes), 1))
        return np.asarray(self._spline(meshes))

    def error(self, channel: int, meshes: float, near: FloatArray | None = None) -> FloatArray:
        """Covariance of the emulator's errors of a channel's amounts, (shapes, shapes).

        Parameters
        ----------
        channel : int
        meshes : float
        near : (run,) bool array, optional
            Runs that count.
        """
        left = self.left_out if near is None else self.left_out[near]
        apart = np.einsum("s,rsa->ra", self.weights(np.array([meshes]))[0], left[..., self.parts[channel]])
        return np.asarray(apart.T @ apart / max(apart.shape[0], 1))

    @cached_property
    def _spline(self) -> CubicSpline:
        return CubicSpline(self.runs.levels, np.eye(self.runs.levels.size))


def model_of(runs: Runs, channels: Sequence[Channel]) -> Model:
    """The model from runs."""
    shapes = tuple(_shapes(values, channel.movements) for values, channel in zip(runs.values, channels, strict=True))
    amounts = np.concatenate([values @ basis for values, basis in zip(runs.values, shapes, strict=True)], axis=-1)
    count = runs.inputs.shape[0]
    flat = amounts.reshape(count, -1)
    mean = flat.mean(axis=0)
    if count == 1 or not runs.inputs.shape[1]:
        none = np.zeros((0, flat.shape[1]))
        return Model(runs, shapes, (), none, mean, np.zeros_like(amounts))
    scale = _scales(amounts, shapes)
    _, sizes, components = np.linalg.svd((flat - mean) / scale, full_matrices=False)
    kept = min(_count(sizes, _LEFT_OF_AMOUNTS, float(np.sum((flat / scale) ** 2))), _MOST_COMPONENTS)
    components = components[:kept]
    scores = ((flat - mean) / scale) @ components.T
    emulators = tuple(emulator_of(runs.inputs, scores[:, k]) for k in range(kept))
    left = np.stack([emulator.left_out for emulator in emulators], axis=1)
    beyond = flat - mean - (scores @ components) * scale
    left_out = (left @ components) * scale + beyond
    return Model(runs, shapes, emulators, components * scale, mean, left_out.reshape(amounts.shape))


def _shapes(values: FloatArray, movements: FloatArray) -> FloatArray:
    """Shapes of predictions, orthogonal to the movements of a datum: (places, shapes)."""
    flat = values.reshape(-1, values.shape[-1])
    if movements.shape[1]:
        basis = np.linalg.qr(movements)[0]
        flat = flat - (flat @ basis) @ basis.T
    _, sizes, shapes = np.linalg.svd(flat, full_matrices=False)
    return np.asarray(shapes[: min(_count(sizes, _LEFT, float(np.sum(sizes**2))), _MOST_SHAPES)].T)


def _count(sizes: FloatArray, left: float, whole: float) -> int:
    """Number of singular values that leave the fraction `left` squared of a sum of squares."""
    beyond = np.append(np.cumsum(sizes[::-1] ** 2)[::-1], 0.0)
    return max(int(np.argmax(beyond <= left**2 * whole)), 1)


def _scales(amounts: FloatArray, shapes: Sequence[FloatArray]) -> FloatArray:
    """Root mean square of each channel's amounts, for every state and amount."""
    scale = np.empty(amounts.shape[1:])
    low = 0
    for basis in shapes:
        part = slice(low, low + basis.shape[1])
        spread = amounts[..., part] - amounts[..., part].mean(axis=0)
        size = np.sqrt(np.mean(np.sum(spread**2, axis=-1)))
        scale[:, part] = size if size > 0.0 else 1.0
        low = part.stop
    return scale.ravel()
