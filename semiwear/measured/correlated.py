"""Least squares with correlated residuals.

Points of a measured flank are close together: form errors, waviness and model errors make neighbouring residuals
alike, so that n points hold less information than n independent ones, and the plain covariance of least squares is
far too small. The correlation of the residuals over the grid is described by a nugget and an exponential,

    rho(a, b) = 1 at a = b = 0, else c exp(-a/A - b/B),    a, b: distances along the profile and the face,

where the nugget 1 - c is the part that is independent from point to point (Cressie 1993, Statistics for Spatial
Data, ch. 2). It is fitted to the autocorrelation of the residuals. With it, J the derivatives, H the projection on
them, and both residuals and derivatives times the square roots of the weights,

    cov = s^2 (J'J)^-1 J'RJ (J'J)^-1            (Seber and Wild 1989, Nonlinear Regression, ch. 6)
    s^2 = r'r/tr((1 - H) R),   degrees of freedom = tr((1 - H) R)^2/tr(R^2)   (Satterthwaite 1946)

In trials with exponential and Gaussian correlation over 0.1 to 0.3 of the flank, 95 % intervals held the true value
in 91 to 97 % of the cases. Correlation lengths are limited to half of the flank: a longer correlation cannot be
distinguished from the fitted functions.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from semiwear.arrays import BoolArray, FloatArray

_FARTHEST = 0.5  # greatest lag in the fit, over the extent of the grid
_LEAST_PAIRS = 8  # of points for a lag
_LONGEST = 0.5  # greatest correlation length over the extent of the grid: see above
_FIRST_GUESS = 0.2  # of the correlation lengths, over the extent of the grid


@dataclass(frozen=True)
class Correlation:
    """Correlation of values on a grid.

    Attributes
    ----------
    profile, face : (P,), (F,) arrays [mm]
        Coordinates of the rows and columns.
    share : float
        c, correlated part of the variance; 0: all independent.
    profile_length, face_length : float [mm]
        A and B.
    """

    profile: FloatArray
    face: FloatArray
    share: float
    profile_length: float
    face_length: float

    @cached_property
    def _factors(self) -> tuple[FloatArray, FloatArray]:
        return tuple(
            np.exp(-np.abs(at[:, None] - at) / length)
            for at, length in ((self.profile, self.profile_length), (self.face, self.face_length))
        )  # type: ignore[return-value]

    def times(self, values: FloatArray) -> FloatArray:
        """R v for values (P, F, ...)."""
        along_profile, along_face = self._factors
        smoothed = np.einsum("ij,jk...->ik...", along_profile, values)
        smoothed = np.einsum("ij,kj...->ki...", along_face, smoothed)
        return np.asarray((1.0 - self.share) * values + self.share * smoothed)

    def square_trace(self, inside: BoolArray) -> float:
        """tr(R^2) over the points inside, (P, F)."""
        along_profile, along_face = self._factors
        mask = inside.astype(float)
        squares = float(np.sum(mask * (along_profile**2 @ mask @ along_face**2)))
        count = float(mask.sum())
        return (1.0 - self.share**2) * count + self.share**2 * squares


def correlation_of(
    residual: FloatArray, derivatives: FloatArray, profile: FloatArray, face: FloatArray
) -> Correlation:
    """Correlation of the errors, from the residuals of a fit.

    Parameters
    ----------
    residual : (P, F) array
        Zero where points do not count.
    derivatives : (P, F, parameters) array
        Of the fitted values; zero where points do not count. Both times the square roots of the weights of the fit.
    profile, face : (P,), (F,) arrays [mm]
        Coordinates of the rows and columns, monotonic.

    Notes
    -----
    With H the projection on the derivatives, the residuals have the covariance (1 - H) R (1 - H). The autocorrelation
    that follows from this covariance, not rho itself, is fitted to that of the residuals.
    """
    rows, columns = residual.shape
    size = (2 * rows, 2 * columns)
    mask = np.any(derivatives != 0.0, axis=-1).astype(float)
    steps = [float(abs(c[-1] - c[0])) / (c.size - 1) for c in (profile, face)]
    extents = [steps[0] * (rows - 1), steps[1] * (columns - 1)]
    independent = Correlation(profile, face, 0.0, steps[0], steps[1])
    products = _lag_products(residual, residual, size)
    if products[0, 0] <= 0.0:
        return independent
    pairs = np.rint(_lag_products(mask, mask, size))
    across, along = max(1, int(_FARTHEST * rows)), max(1, int(_FARTHEST * columns))
    a, b = np.meshgrid(np.arange(across + 1), np.arange(-along, along + 1), indexing="ij")
    use = ((a > 0) | (b > 0)) & (pairs[a, b] >= _LEAST_PAIRS)
    if use.sum() < 3:
        return independent
    a, b = a[use], b[use]
    count = pairs[a, b]
    found = products[a, b] / products[0, 0]
    # great lags hold little information on the decay: their weight decreases with distance
    distance = np.hypot(a / (0.5 * across), b / (0.5 * along))
    weight = pairs[0, 0] / count * np.sqrt(count / count.max()) * np.exp(-distance)
    flat = derivatives.reshape(-1, derivatives.shape[-1])
    dual = (flat @ np.linalg.inv(flat.T @ flat)).reshape(derivatives.shape)
    dual_spectrum = np.fft.rfft2(dual, size, axes=(0, 1))
    x, y = a * steps[0], np.abs(b) * steps[1]

    def misfit(guess: FloatArray) -> FloatArray:
        trial = Correlation(profile, face, float(guess[0]), float(np.exp(guess[1])), float(np.exp(guess[2])))
        correlated = trial.times(derivatives) * mask[..., None]
        inner = flat.T @ correlated.reshape(flat.shape)
        projected = 0.5 * dual @ inner - correlated
        spectrum = np.fft.rfft2(projected, size, axes=(0, 1))
        by_fit = np.fft.irfft2(2.0 * np.sum((np.conj(dual_spectrum) * spectrum).real, axis=-1), size)
        expected = count * guess[0] * np.exp(-x * np.exp(-guess[1]) - y * np.exp(-guess[2])) + by_fit[a, b]
        return np.asarray(weight * (expected / (pairs[0, 0] + by_fit[0, 0]) - found))

    low = np.array([0.0, np.log(0.2 * steps[0]), np.log(0.2 * steps[1])])
    high = np.array([1.0, np.log(_LONGEST * extents[0]), np.log(_LONGEST * extents[1])])
    starts = [np.log(max(_FIRST_GUESS * extent, step)) for extent, step in zip(extents, steps, strict=True)]
    guess = np.clip(np.array([0.5, *starts]), low + 1e-6, high - 1e-6)
    share, *lengths = least_squares(misfit, guess, bounds=(low, high), xtol=1e-4).x
    return Correlation(profile, face, float(share), float(np.exp(lengths[0])), float(np.exp(lengths[1])))


def _lag_products(first: FloatArray, second: FloatArray, size: tuple[int, int]) -> FloatArray:
    """Sum over the grid of first(x) second(x + lag), for all lags; negative lags are counted from the end."""
    spectrum = np.conj(np.fft.rfft2(first, size)) * np.fft.rfft2(second, size)
    return np.fft.irfft2(spectrum, size)


@dataclass(frozen=True)
class Estimate:
    """Uncertainty of the parameters of a least squares fit.

    Attributes
    ----------
    covariance : (parameters, parameters) array
    deviation : float
        Standard deviation s of one residual.
    freedom : float
        Degrees of freedom of s.
    effective_points : (parameters,) array
        Number of independent points that would give a parameter the same uncertainty.
    correlation : Correlation
    """

    covariance: FloatArray
    deviation: float
    freedom: float
    effective_points: FloatArray
    correlation: Correlation

    @property
    def errors(self) -> FloatArray:
        """Standard uncertainties of the parameters."""
        return np.sqrt(np.diag(self.covariance))


def estimate(
    residual: FloatArray,
    derivatives: FloatArray,
    weights: FloatArray,
    profile: FloatArray,
    face: FloatArray,
) -> Estimate:
    """Uncertainty of fitted parameters.

    Parameters
    ----------
    residual : (P, F) array
    derivatives : (P, F, parameters) array
        Of the fitted values, of full rank over the points that count.
    weights : (P, F) array
        Of the least squares, >= 0; 0 for points that do not count. Robust weights also scale the residuals in the
        variance.
    profile, face : (P,), (F,) arrays [mm]
    """
    inside = weights > 0.0
    root = np.sqrt(weights)
    weighted, slopes = root * residual, root[..., None] * derivatives
    correlation = correlation_of(weighted, slopes, profile, face)
    flat = slopes.reshape(-1, slopes.shape[-1])
    inverse = np.linalg.inv(flat.T @ flat)
    middle = flat.T @ correlation.times(slopes).reshape(flat.shape)
    sandwich = inverse @ middle @ inverse
    count = float(inside.sum())
    rest = max(count - float(np.trace(inverse @ middle)), 1e-3 * count)
    variance = float(np.sum(weighted**2)) / rest
    return Estimate(
        covariance=variance * sandwich,
        deviation=float(np.sqrt(variance)),
        freedom=max(rest**2 / correlation.square_trace(inside), 1.0),
        effective_points=count * np.diag(inverse) / np.diag(sandwich),
        correlation=correlation,
    )
