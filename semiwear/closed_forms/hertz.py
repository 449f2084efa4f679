"""Closed forms of Hertzian contact (Johnson, *Contact Mechanics*, 1985, ch. 4)."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, log, pi, sqrt

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import elliprd, elliprf

from semiwear.argument_ranges import require_range
from semiwear.arrays import FloatArray

_LEAST_COMPLEMENT = 1e-14  # of 1 - e^2, the square of the half-axes' ratio


def effective_modulus(
    youngs_modulus_1: float, poissons_ratio_1: float, youngs_modulus_2: float, poissons_ratio_2: float
) -> float:
    """Effective modulus E* [MPa]: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 (Johnson 1985, eq. 4.20).

    Parameters
    ----------
    youngs_modulus_1, youngs_modulus_2 : float [MPa]
        Of the two bodies; infinite for a rigid one.
    poissons_ratio_1, poissons_ratio_2 : float
        Above -1, up to 0.5.

    Raises
    ------
    ValueError
        A number is out of its range.

    Examples
    --------
    >>> from semiwear.contact import effective_modulus
    >>> print(f"{effective_modulus(206e3, 0.3, 206e3, 0.3):.0f}")
    113187
    """
    if not (youngs_modulus_1 > 0.0 and youngs_modulus_2 > 0.0):
        raise ValueError(f"Young's moduli must be above 0 MPa, not {youngs_modulus_1} and {youngs_modulus_2}")
    require_range("Poisson's ratio", (poissons_ratio_1, poissons_ratio_2), above=-1.0, most=0.5)
    return 1.0 / ((1.0 - poissons_ratio_1**2) / youngs_modulus_1 + (1.0 - poissons_ratio_2**2) / youngs_modulus_2)


def line_contact_half_width(line_load: ArrayLike, curvature: ArrayLike, modulus: float) -> FloatArray:
    """Half-width b = sqrt(4 q R / (pi E*)) of a line contact [mm] (Johnson 1985, eq. 4.43).

    Parameters
    ----------
    line_load : array [N/mm]
        At least 0.
    curvature : array [1/mm]
        Relative curvature 1/R across the line, above 0 under load; it broadcasts with `line_load`.
    modulus : float [MPa]
        Effective modulus E*, above 0.

    Raises
    ------
    ValueError
        A number is out of its range.

    Examples
    --------
    >>> from semiwear.contact import line_contact_half_width
    >>> print(f"{line_contact_half_width(300.0, 0.1, 113e3):.4f}")
    0.1839
    """
    _check_line_contact(line_load, curvature, modulus)
    return np.sqrt(np.multiply(4.0, line_load) / np.multiply(pi * modulus, curvature))


def line_contact_pressure(line_load: ArrayLike, curvature: ArrayLike, modulus: float) -> FloatArray:
    """Greatest pressure p0 = sqrt(q E* / (pi R)) of a line contact [MPa] (Johnson 1985, eq. 4.45).

    Parameters
    ----------
    line_load : array [N/mm]
        At least 0.
    curvature : array [1/mm]
        Relative curvature 1/R across the line, above 0 under load; it broadcasts with `line_load`.
    modulus : float [MPa]
        Effective modulus E*, above 0.

    Raises
    ------
    ValueError
        A number is out of its range.

    Examples
    --------
    >>> from semiwear.contact import line_contact_pressure
    >>> print(f"{line_contact_pressure(300.0, 0.1, 113e3):.0f}")
    1039
    """
    _check_line_contact(line_load, curvature, modulus)
    return np.sqrt(np.multiply(np.multiply(line_load, modulus), curvature) / pi)


def _check_line_contact(line_load: ArrayLike, curvature: ArrayLike, modulus: float) -> None:
    """Missing numbers (NaN) pass, and stay missing."""
    require_range("the line load", line_load, "N/mm", least=0.0, missing=True)
    hint = "of a concave and a convex body it is the difference of their curvatures"
    loaded = np.where(np.greater(line_load, 0.0), curvature, 1.0)  # flanks may be of any shape where they part
    require_range("the relative curvature under load", loaded, "1/mm", above=0.0, missing=True, hint=hint)
    require_range("the effective modulus", modulus, "MPa", above=0.0)


@dataclass(frozen=True)
class EllipticContact:
    """Solution of an elliptic Hertz contact.

    Attributes
    ----------
    major_half_axis, minor_half_axis : float [mm]
        Of the contact ellipse.
    peak_pressure : float [MPa]
        In the middle of the ellipse.
    approach : float [mm]
        How far points of the two bodies far from the contact approach each other.
    """

    major_half_axis: float
    minor_half_axis: float
    peak_pressure: float
    approach: float


def elliptic_contact(load: float, curvature_1: float, curvature_2: float, modulus: float) -> EllipticContact:
    """Elliptic Hertz contact under a load (Johnson 1985, eqs. 4.26 to 4.32, solved exactly).

    Parameters
    ----------
    load : float [N]
    curvature_1, curvature_2 : float [1/mm]
        Relative principal curvatures.
    modulus : float [MPa]
        Effective modulus E*.

    Raises
    ------
    ValueError
        A number is not positive and finite, or one curvature is so much less than the other that this is a line
        contact.

    Examples
    --------
    >>> from semiwear.contact import elliptic_contact
    >>> found = elliptic_contact(1000.0, 0.05, 0.05, 115e3)  # a sphere of 20 mm radius
    >>> print(f"{found.major_half_axis:.4f} {found.minor_half_axis:.4f} {found.peak_pressure:.0f}")
    0.5071 0.5071 1856
    """
    low, high = sorted((curvature_1, curvature_2))
    if not all(0.0 < value < np.inf for value in (load, low, high, modulus)):
        raise ValueError(
            "an elliptic contact needs a load, two relative curvatures and a modulus that are positive and finite; "
            f"found {load:g} N, {low:g} and {high:g} 1/mm, {modulus:g} MPa"
        )

    # complement = (b/a)^2 = 1 - e^2; K and D = (K - E)/e^2 in Carlson's forms, which keep their digits as e -> 0
    def integrals(complement: float) -> tuple[float, float]:
        return float(elliprf(0.0, complement, 1.0)), float(elliprd(0.0, complement, 1.0)) / 3.0

    def excess(complement: float) -> float:
        k, d = integrals(complement)
        return (k - d) / (complement * d) - high / low

    if excess(_LEAST_COMPLEMENT) < 0.0:
        raise ValueError(
            f"relative curvatures of {low:g} and {high:g} 1/mm make an ellipse without end: take "
            "`line_contact_pressure`"
        )
    complement = 1.0
    if excess(1.0) < 0.0:  # by its logarithm, since a long ellipse has a very small one
        complement = exp(brentq(lambda logarithm: excess(exp(logarithm)), log(_LEAST_COMPLEMENT), 0.0, xtol=1e-15))
    k, shape = integrals(complement)
    ratio = sqrt(complement)
    # 2 A = low = (2 p0 b / (E* a^2)) (K - E)/e^2 with p0 = 3 P/(2 pi a b)  ->  a^3
    major = (3.0 * load * shape / (pi * modulus * low)) ** (1.0 / 3.0)
    minor = major * ratio
    peak = 1.5 * load / (pi * major * minor)
    return EllipticContact(major, minor, peak, peak * minor * k / modulus)
