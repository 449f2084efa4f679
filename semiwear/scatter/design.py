"""Samples of several fields: scrambled Sobol' sequences, correlated by rank, and the pairs for Sobol' indices.

A sequence of twice as many samples begins with the shorter one: an extended study solves only new scenes
(Sobol' 1967, USSR Comput. Math. Math. Phys. 7, 86-112; Owen 1998, ACM Trans. Model. Comput. Simul. 8, 71-102.)

Correlation by rank is that of a Gaussian copula: normal numbers with the correlation 2 sin(pi rho / 6) have the rank
correlation rho of Spearman (Pearson 1907; Iman and Conover 1982, Commun. Stat. B 11, 311-334).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from scipy.special import ndtr, ndtri

from semiwear.arrays import FloatArray
from semiwear.errors import Problem
from semiwear.scatter.distributions import Distribution
from semiwear.scene.closest import advised_name
from semiwear.scene.values import is_number, shown

_LEAST = 2.0**-40  # a probability of 0 has no finite quantile


@dataclass(frozen=True)
class Design:
    """Values of fields in all samples.

    Attributes
    ----------
    values : array (sample, field)
        First `count` independent samples; with `paired` another `count` of them, and then, for each field, the first
        ones with that field's values from the second ones.
    count : int
    paired : bool
    """

    values: FloatArray
    count: int
    paired: bool


def design(
    distributions: Sequence[Distribution], count: int, seed: int, *, matrix: FloatArray | None = None, paired: bool
) -> Design:
    """Samples of several fields.

    Parameters
    ----------
    distributions : sequence of Distribution
    count : int
        A power of two.
    seed : int
    matrix : array (field, field), optional
        Correlation of the normal numbers behind the samples; not for paired samples.
    paired : bool
        Whether to add the samples for Sobol' indices: (number of fields + 2) times `count` in total.
    """
    fields = len(distributions)
    columns = 2 * fields if paired else fields
    share = scipy.stats.qmc.Sobol(columns, scramble=True, seed=np.random.default_rng(seed)).random(count)
    share = np.clip(share, _LEAST, 1.0 - _LEAST)
    if matrix is not None:
        share = ndtr(ndtri(share) @ np.linalg.cholesky(matrix).T)

    def values(shares: FloatArray) -> FloatArray:
        return np.stack([distribution.quantile(shares[:, k]) for k, distribution in enumerate(distributions)], axis=1)

    first = values(share[:, :fields])
    if not paired:
        return Design(first, count, False)
    second = values(share[:, fields:])
    mixed = [np.where(np.arange(fields) == k, second, first) for k in range(fields)]
    return Design(np.concatenate([first, second, *mixed]), count, True)


def read_correlation(
    fields: Sequence[str], pairs: Mapping[tuple[str, str], float], problems: list[Problem]
) -> FloatArray | None:
    """`correlation_matrix`, or None if there is none or it has faults."""
    before = len(problems)
    for pair, rank in pairs.items():
        named = pair if isinstance(pair, tuple) and len(pair) == 2 else ()
        for name in named:
            if name not in fields:
                fix = advised_name(str(name), fields, "give it a distribution")
                problems.append(Problem("correlation", shown(name), f"one of {', '.join(fields)}", fix))
        if len(set(named)) != 2:
            problems.append(Problem("correlation", shown(pair), "pairs of two fields", 'e.g. {("a", "b"): 0.5}'))
        if not is_number(rank) or not -1.0 < rank < 1.0:
            problems.append(
                Problem(f"correlation of {pair}", shown(rank), "above -1 and below 1", "a rank correlation")
            )
    if not pairs or len(problems) > before:
        return None
    matrix = correlation_matrix(fields, pairs)
    if np.linalg.eigvalsh(matrix)[0] <= 1e-10:
        fix = "make them weaker, or leave one out: fields that correlate with a third correlate with each other"
        problems.append(Problem("correlation", shown(dict(pairs)), "correlations that are compatible", fix))
        return None
    return matrix


def correlation_matrix(fields: Sequence[str], pairs: Mapping[tuple[str, str], float]) -> FloatArray:
    """Correlation of normal numbers with the given rank correlations: (field, field)."""
    matrix = np.eye(len(fields))
    for (first, second), rank in pairs.items():
        i, j = fields.index(first), fields.index(second)
        matrix[i, j] = matrix[j, i] = 2.0 * np.sin(np.pi * rank / 6.0)
    return matrix
