"""Fields that observations leave open: those of which they say nothing, and those that they tell only together."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.inference.unknowns import Unknown
from semiwear.scene.units import unit_of

__all__ = ["not_told_apart"]

_NOTHING = 0.8  # of the prior's standard deviation: little was learnt
_TOGETHER = 0.8  # correlation
_BLURRED = 3.0  # times as uncertain alone as together


def not_told_apart(unknowns: Sequence[Unknown], values: FloatArray, shares: FloatArray) -> tuple[str, ...]:
    """Sentences on fields that were not told, alone or apart from each other.

    Parameters
    ----------
    unknowns : sequence of Unknown
    values : array (draw, unknown)
        Draws of the posterior.
    shares : array (unknown,)
        Standard deviation of each over its prior's.
    """
    found = []
    for one, share in zip(unknowns, shares, strict=True):
        if share > _NOTHING:
            found.append(f"{one.key}: hardly told; {100.0 * share:.0f} % of its prior's scatter is left")
    scaled = [np.log(values[:, k]) if one.ratio else values[:, k] for k, one in enumerate(unknowns)]
    pairs = []
    for i, j in combinations(range(len(unknowns)), 2):
        correlation = float(np.corrcoef(scaled[i], scaled[j])[0, 1])
        if abs(correlation) >= _TOGETHER:
            pairs.append((abs(correlation), _sentence(unknowns[i], unknowns[j], scaled[i], scaled[j], correlation)))
    return (*found, *(text for _, text in sorted(pairs, reverse=True)))


def _sentence(first: Unknown, second: Unknown, a: FloatArray, b: FloatArray, correlation: float) -> str:
    """A pair that is told together: the combination that is known best, and how well each is alone."""
    alone = f"alone {first.name} is within {_spread(first, a)}, {second.name} within {_spread(second, b)}"
    if first.ratio and second.ratio:
        # the direction of least scatter, ln first + n ln second
        least = np.linalg.eigh(np.cov(a, b))[1][:, 0]
        power = float(least[1] / least[0])
        known = a + power * b
        told = f"{first.name} x {second.name}^{power:.2f}"
        blurred = min(a.std(), b.std() * max(abs(power), 1.0)) > _BLURRED * known.std()
        how = "cannot be told apart" if blurred else "are told better together than apart"
        return (
            f"{first.key} and {second.key} {how}: {told} is known within "
            f"{100.0 * np.expm1(known.std()):.2g} %, {alone} (one standard deviation; correlation {correlation:+.2f})"
        )
    return (
        f"{first.key} and {second.key} are told together rather than apart: their correlation is {correlation:+.2f}; "
        f"{alone} (one standard deviation)"
    )


def _spread(one: Unknown, scaled: FloatArray) -> str:
    """Standard deviation as a reader writes it."""
    if one.ratio:
        return f"{100.0 * np.expm1(scaled.std()):.2g} %"
    units = unit_of(one.key)
    return f"{scaled.std():.2g}{'' if units == '1' else f' {units}'}"
