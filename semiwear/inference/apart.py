"""Fields that observations do not determine: single ones, and pairs that are determined only in combination."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.inference.unknowns import Unknown
from semiwear.scene.units import unit_of

_UNLEARNT = 0.8  # of the prior's standard deviation: above it, little was learnt
_TOGETHER = 0.8  # correlation
_BLURRED = 3.0  # times as uncertain alone as together


def undetermined_fields(unknowns: Sequence[Unknown], values: FloatArray, shares: FloatArray) -> tuple[str, ...]:
    """Sentences on fields that are not determined, singly or independently of each other.

    Parameters
    ----------
    unknowns : sequence of Unknown
    values : array (draw, unknown)
        Draws of the posterior.
    shares : array (unknown,)
        Standard deviation of each over its prior's.
    """
    found = []
    for unknown, share in zip(unknowns, shares, strict=True):
        if share > _UNLEARNT:
            found.append(f"{unknown.key}: hardly determined; {100.0 * share:.0f} % of its prior's scatter is left")
    scaled = [np.log(values[:, k]) if unknown.ratio else values[:, k] for k, unknown in enumerate(unknowns)]
    pairs = []
    for i, j in combinations(range(len(unknowns)), 2):
        correlation = float(np.corrcoef(scaled[i], scaled[j])[0, 1])
        if abs(correlation) >= _TOGETHER:
            pairs.append((abs(correlation), _sentence(unknowns[i], unknowns[j], scaled[i], scaled[j], correlation)))
    return (*found, *(text for _, text in sorted(pairs, reverse=True)))


def _sentence(first: Unknown, second: Unknown, a: FloatArray, b: FloatArray, correlation: float) -> str:
    """A correlated pair: the combination that is known best, and the uncertainty of each field alone."""
    alone = f"alone {first.name} is within {_spread(first, a)}, {second.name} within {_spread(second, b)}"
    if first.ratio and second.ratio:
        # the direction of least scatter, ln first + n ln second
        least = np.linalg.eigh(np.cov(a, b))[1][:, 0]
        power = float(least[1] / least[0])
        known = a + power * b
        combination = f"{first.name} x {second.name}^{power:.2f}"
        blurred = min(a.std(), b.std() * max(abs(power), 1.0)) > _BLURRED * known.std()
        relation = "cannot be distinguished" if blurred else "are better determined together than singly"
        return (
            f"{first.key} and {second.key} {relation}: {combination} is known within "
            f"{100.0 * np.expm1(known.std()):.2g} %, {alone} (one standard deviation; correlation {correlation:+.2f})"
        )
    return (
        f"{first.key} and {second.key} are determined together, not singly: their correlation is {correlation:+.2f}; "
        f"{alone} (one standard deviation)"
    )


def _spread(unknown: Unknown, scaled: FloatArray) -> str:
    """Standard deviation in printed notation."""
    if unknown.ratio:
        return f"{100.0 * np.expm1(scaled.std()):.2g} %"
    units = unit_of(unknown.key)
    return f"{scaled.std():.2g}{'' if units == '1' else f' {units}'}"
