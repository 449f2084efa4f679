"""Life with uncertainty: quantiles that follow from how uncertain the wear coefficient is.

A life L to a depth is inversely proportional to the wear coefficient, exactly: wear knows it only times the meshes.
With ln k normal, ln L is normal with the same standard deviation:

    L_q = L(k) exp(z_q s),    s^2 = s_k^2 (1 + 1/n) + u^2/n

s_k: standard deviation of ln k from part to part; with n parts measured, their median is itself uncertain by
s_k/sqrt(n); u: uncertainty of each part's fit. L_q is the life that a part chosen next falls short of with
probability q: q = 0.1 is the life B10.

How much k scatters: repeated wear tests of like parts differ by tens of per cent, from laboratory to laboratory by
more (Blau 2017, Wear 376-377, 1830-1840, surveys it). The default, a coefficient of variation of one half, is an
assumption of that order, no measurement: s_k = sqrt(ln(1 + 0.5^2)) = 0.472. Where enough parts were measured, their
own scatter takes its place, and Student's t that of the normal distribution.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import exp, isfinite, log, sqrt

import numpy as np
from scipy.stats import norm
from scipy.stats import t as student

from semiwear.errors import SceneError
from semiwear.plain_text import folded

QUANTILES = (0.1, 0.5, 0.9)
"""Shares of parts that have reached the depth: B10, median, B90."""

MOST_SCATTER = 100.0
"""Greatest coefficient of variation of k that is taken for one."""


def log_deviation(variation: float) -> float:
    """Standard deviation of the logarithm of a log-normal quantity with a coefficient of variation."""
    return sqrt(log(1.0 + variation**2))


def require_share(share: float) -> None:
    """Refuse a share that no quantile has.

    Raises
    ------
    SceneError
        For a share not between 0 and 1.
    """
    if not 0.0 < share < 1.0:
        raise SceneError.of("share", share, "above 0 and below 1", "0.1 for the life B10")


def quantiles_told(quantile: Callable[[float], float], hours: Callable[[float], float | None]) -> str:
    """B10, median and B90 in words: quantiles of meshes, and of running time [h] where that is known."""
    parts = []
    for share in QUANTILES:
        meshes, time = quantile(share), hours(share)
        told = "" if time is None else f" ({time:.4g} h)"
        told = f"{meshes:.4g} meshes{told}" if isfinite(meshes) else "without end"
        parts.append(f"B{100 * share:.0f} {told}")
    return ", ".join(parts)


@dataclass(frozen=True)
class LifeSpread:
    """Life until a depth of wear, with its spread.

    Attributes
    ----------
    body : str
    depth_limit : float [um]
    median : float
        Engagements of one gear tooth.
    log_deviation : float
        s, of ln L.
    freedom : float
        Degrees of freedom of s: infinite where the scatter of k was given.
    k_scatter : float
        Coefficient of variation of k from part to part that went in.
    hours_per_mesh : float or None
        Running time; None where the scene gives no speed.
    """

    body: str
    depth_limit: float
    median: float
    log_deviation: float
    freedom: float = float("inf")
    k_scatter: float = 0.0
    hours_per_mesh: float | None = None

    def quantile(self, share: float) -> float:
        """Meshes before which this share of parts has reached the depth.

        Raises
        ------
        SceneError
            For a share not between 0 and 1.
        """
        require_share(share)
        place = norm.ppf(share) if np.isinf(self.freedom) else student.ppf(share, self.freedom)
        return self.median * exp(float(place) * self.log_deviation)

    def hours(self, share: float) -> float | None:
        """The same as running time [h]; None where the scene gives no speed."""
        return None if self.hours_per_mesh is None else self.quantile(share) * self.hours_per_mesh

    def quantiles(self, shares: Sequence[float] = QUANTILES) -> tuple[float, ...]:
        """`quantile` of several shares."""
        return tuple(self.quantile(share) for share in shares)

    def __str__(self) -> str:
        told = quantiles_told(self.quantile, self.hours)
        spread = 100.0 * sqrt(exp(self.log_deviation**2) - 1.0)
        return folded(
            f"life of the {self.body} until {self.depth_limit:g} um: {told}; k scatters by "
            f"{100.0 * self.k_scatter:.0f} % from part to part, the life of the next part by {spread:.0f} %"
        )
