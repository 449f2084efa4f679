"""Life with uncertainty: quantiles of life from the uncertainty of the wear coefficient.

A life L to a depth is inversely proportional to the wear coefficient, exactly, since wear depends on the product of
coefficient and meshes. With ln k normal, ln L is normal with the same standard deviation:

    L_q = L(k) exp(z_q s),    s^2 = s_k^2 (1 + 1/n) + u^2/n

s_k: standard deviation of ln k from part to part; with n measured parts, their median has the uncertainty
s_k/sqrt(n); u: uncertainty of the fit of each part. The next part fails before L_q with probability q; q = 0.1 gives
the life B10.

Scatter of k: repeated wear tests of the same kind of part differ by tens of per cent, and more between laboratories
(survey: Blau 2017, Wear 376-377, 1830-1840). The default, a coefficient of variation of one half, is an assumption
of that order, not a measurement: s_k = sqrt(ln(1 + 0.5^2)) = 0.472. If enough parts were measured, their own scatter
is used instead, with Student's t in place of the normal distribution.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import exp, isfinite, log, sqrt

import numpy as np
import scipy

from semiwear.errors import SceneError
from semiwear.plain_text import folded

QUANTILES = (0.1, 0.5, 0.9)
"""Shares of parts that have reached the depth: B10, median, B90."""

MOST_SCATTER = 100.0
"""Greatest accepted coefficient of variation of k."""


def log_deviation(variation: float) -> float:
    """Standard deviation of the logarithm of a log-normal quantity with a coefficient of variation."""
    return sqrt(log(1.0 + variation**2))


def require_share(share: float) -> None:
    """Refuse a share outside the range of quantiles.

    Raises
    ------
    SceneError
        For a share not between 0 and 1.
    """
    if not 0.0 < share < 1.0:
        raise SceneError.of("share", share, "above 0 and below 1", "0.1 for the life B10")


def quantiles_in_words(quantile: Callable[[float], float], hours: Callable[[float], float | None]) -> str:
    """B10, median and B90 as text: quantiles of meshes, and of running time [h] where it is known."""
    parts = []
    for share in QUANTILES:
        meshes, time = quantile(share), hours(share)
        running_time = "" if time is None else f" ({time:.4g} h)"
        life = f"{meshes:.4g} meshes{running_time}" if isfinite(meshes) else "without end"
        parts.append(f"B{100 * share:.0f} {life}")
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
        s, standard deviation of ln L.
    freedom : float
        Degrees of freedom of s: infinite if the scatter of k was given.
    k_scatter : float
        Coefficient of variation of k from part to part.
    hours_per_mesh : float or None
        Running time; None if the scene gives no speed.
    """

    body: str
    depth_limit: float
    median: float
    log_deviation: float
    freedom: float = float("inf")
    k_scatter: float = 0.0
    hours_per_mesh: float | None = None

    def quantile(self, share: float) -> float:
        """Meshes after which this share of parts has reached the depth.

        Raises
        ------
        SceneError
            For a share not between 0 and 1.
        """
        require_share(share)
        score = scipy.stats.norm.ppf(share) if np.isinf(self.freedom) else scipy.stats.t.ppf(share, self.freedom)
        return self.median * exp(float(score) * self.log_deviation)

    def hours(self, share: float) -> float | None:
        """The same quantile as running time [h]; None if the scene gives no speed."""
        return None if self.hours_per_mesh is None else self.quantile(share) * self.hours_per_mesh

    def quantiles(self, shares: Sequence[float] = QUANTILES) -> tuple[float, ...]:
        """`quantile` for several shares."""
        return tuple(self.quantile(share) for share in shares)

    def __str__(self) -> str:
        quantiles = quantiles_in_words(self.quantile, self.hours)
        spread = 100.0 * sqrt(exp(self.log_deviation**2) - 1.0)
        return folded(
            f"life of the {self.body} until {self.depth_limit:g} um: {quantiles}; k scatters by "
            f"{100.0 * self.k_scatter:.0f} % from part to part, the life of the next part by {spread:.0f} %"
        )
