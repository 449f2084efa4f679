"""Which torque would give a printed figure: the inverse of the model, for each figure and for all at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from semiwear.arrays import FloatArray


@dataclass(frozen=True)
class Inferred:
    """Torques at which the model gives a printed figure.

    Attributes
    ----------
    name : str
    printed : float
    torques : tuple of float [N m]
        Every one within the range that was searched; empty if there is none.
    range : (float, float)
        Least and greatest figure that the model gives in the range of torques.
    checked : tuple of float
        The model's figure at each of the torques, computed there and not interpolated; empty if that was not done.
    """

    name: str
    printed: float
    torques: tuple[float, ...]
    range: tuple[float, float]
    checked: tuple[float, ...] = ()


def _curve(torques: FloatArray, values: FloatArray) -> PchipInterpolator:
    """The figure over the logarithm of the torque: monotone wherever the points are."""
    return PchipInterpolator(np.log(torques), values)


def inferred_torque(
    name: str,
    printed: float,
    torques: Sequence[float],
    values: Sequence[float],
    model: Callable[[float], float] | None = None,
) -> Inferred:
    """Solve the model for a torque.

    Parameters
    ----------
    name : str
    printed : float
    torques : sequence of float [N m]
        Increasing, at which the model was computed.
    values : sequence of float
        The figure there.
    model : callable, optional
        From a torque to the figure, to check what was interpolated.

    Returns
    -------
    Inferred
        With several torques where the figure is not monotone.
    """
    at, found = np.asarray(torques, float), np.asarray(values, float)
    curve = _curve(at, found)
    apart = found - printed
    solutions = []
    for k in range(at.size - 1):
        if apart[k] == 0.0:
            solutions.append(float(at[k]))
        elif apart[k] * apart[k + 1] < 0.0:
            low, high = np.log(at[k]), np.log(at[k + 1])
            solutions.append(float(np.exp(brentq(lambda x: float(curve(x)) - printed, low, high))))
    if apart[-1] == 0.0:
        solutions.append(float(at[-1]))
    checked = () if model is None else tuple(model(torque) for torque in solutions)
    return Inferred(name, printed, tuple(solutions), (float(found.min()), float(found.max())), checked)


@dataclass(frozen=True)
class BestTorque:
    """The torque whose worst figure is least wrong.

    Attributes
    ----------
    torque : float [N m]
    worst : float
        Greatest deviation of a figure there, relative to the printed one.
    figure : str
        Which figure that is.
    fits : bool
        Whether all figures are within the tolerance there, so that one torque fits them all.
    """

    torque: float
    worst: float
    figure: str
    fits: bool


def best_torque(
    printed: Mapping[str, float], torques: Sequence[float], values: Mapping[str, Sequence[float]], tolerance: float
) -> BestTorque:
    """Search all torques for the one that fits several figures at once.

    Parameters
    ----------
    printed : mapping of str to float
    torques : sequence of float [N m]
    values : mapping of str to sequence
        The model's figures at the torques.
    tolerance : float
        Within which a figure counts as met, relative.
    """
    at = np.asarray(torques, float)
    fine = np.linspace(np.log(at[0]), np.log(at[-1]), 2001)
    names = list(printed)
    apart = np.array(
        [np.abs(_curve(at, np.asarray(values[name], float))(fine) / printed[name] - 1.0) for name in names]
    )
    worst = apart.max(axis=0)
    k = int(worst.argmin())
    figure = names[int(apart[:, k].argmax())]
    return BestTorque(float(np.exp(fine[k])), float(worst[k]), figure, bool(worst[k] <= tolerance))
