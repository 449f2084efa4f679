"""Likelihood of the amounts of some shapes, from measured values whose noise is known or not.

Measured, y = B b + D a + e: B the shapes of predictions, b their amounts, D the movements that a datum leaves open, a
theirs, e the noise, normal. The information of y on b is a likelihood of b.

Known noise, with a standard uncertainty: a normal distribution of b about its least squares.

Noise of a measured flank is unknown, and correlated at neighbouring points: its covariance is s^2 R, R the nugget and
exponential of `semiwear.measured.correlated` with a share c and two lengths. With flat priors of a and ln s,

    p(y | b) = integral over (c, A, B) of  p(c, A, B | y) t_v(b; b', s'^2 (B'R^-1 B - ...)^-1)

t_v Student's t of v degrees of freedom about the generalised least squares b' (a eliminated), and p(c, A, B | y) the
likelihood of the part that is neither shape nor movement (restricted maximum likelihood: Patterson and Thompson 1971,
Biometrika 58, 545-554; Harville 1974, ibid. 61, 383-385) times a prior that is flat in c and in ln A, ln B. The
integral is approximated by draws only: importance samples from Student's t, first about the maximum
(Geweke 1989, Econometrica 57, 1317-1339), then about the draws themselves. On a grid without holes R is a Kronecker
product, so that each draw costs two small eigenvalue problems.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import sqrt

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit, logsumexp
from scipy.stats import multivariate_t

from semiwear.arrays import FloatArray
from semiwear.untyped import Value

_Conditional = tuple[float, FloatArray, FloatArray, float]
_DRAWS, _ROUNDS = 200, 6  # draws at a time, and most rounds
_WIDER = 4.0  # times the known variance: the tails of a density have more weight than draws within it show
_ENOUGH, _LEAST_EFFECTIVE = 60.0, 20.0  # effective draws: to end with, and for a covariance
_TAIL = 5.0  # degrees of freedom of the draws
_NEGLIGIBLE = 1e-4  # of the weight
_STEP = 0.05  # of differences, in logits
_WIDEST = 25.0  # variance of a logit, at most
SHORTEST, LONGEST = 0.2, 0.5
"""Correlation lengths that can be determined: fractions of a step and of the extent of the grid."""


@dataclass(frozen=True)
class Evidence:
    """Likelihood of the amounts of shapes: a mixture of Student's t, or of normal distributions.

    Attributes
    ----------
    log_weights : (draws,) array
    centres : (draws, shapes) array
    precisions : (draws, shapes, shapes) array
    freedom : float
        Degrees of freedom; infinite for normal distributions.
    deviation : float
        Most likely standard deviation of the noise.
    rest : float
        For known noise: weighted squares of the part that is neither shape nor movement.
    count : int
        For known noise: number of values less movements; 0 for unknown noise.
    """

    log_weights: FloatArray
    centres: FloatArray
    precisions: FloatArray
    freedom: float
    deviation: float
    rest: float = 0.0
    count: int = 0

    def widened(self, covariance: FloatArray) -> Evidence:
        """The same with errors of the predicted amounts, of a covariance (shapes, shapes)."""
        identity = np.eye(covariance.shape[0])
        precisions = np.asarray(np.linalg.solve(identity + self.precisions @ covariance, self.precisions), float)
        return replace(self, precisions=precisions)

    def misfit(self, amounts: FloatArray) -> float:
        """Distance of amounts (shapes,) from the observation, over the mean effect of noise.

        For known noise it includes the part that is no shape; otherwise that part is noise.
        """
        likeliest = int(np.argmax(self.log_weights))
        apart = amounts - self.centres[likeliest]
        squares = float(apart @ self.precisions[likeliest] @ apart) + self.rest
        return sqrt(squares / (self.count or apart.size))

    def log_likelihood(self, amounts: FloatArray) -> FloatArray:
        """Logarithm of the likelihood, up to a constant, of amounts (points, shapes): (points,)."""
        # (v - c)' P (v - c) of every draw, as v'Pv - 2 v'Pc + c'Pc: one product for all points
        about = amounts - self._middle
        products = np.einsum("pi,pj->pij", about, about).reshape(about.shape[0], -1)
        flat, linear, constant = self._expanded
        squares = np.clip(products @ flat + about @ linear + constant, 0.0, None)
        if np.isfinite(self.freedom):
            power = 0.5 * (self.freedom + amounts.shape[1])
            shape = -power * np.log1p(squares / self.freedom)
        else:
            shape = -0.5 * squares
        return np.asarray(logsumexp(self.log_weights + self._half + shape, axis=1))

    @cached_property
    def _middle(self) -> FloatArray:
        return np.asarray(self.centres.mean(axis=0))

    @cached_property
    def _half(self) -> FloatArray:
        return np.asarray(0.5 * np.linalg.slogdet(self.precisions)[1])

    @cached_property
    def _expanded(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Coefficients of the squares about the mean centre: (shapes^2, draws), (shapes, draws), (draws,)."""
        offset = self.centres - self._middle
        linear = np.einsum("dij,dj->id", self.precisions, offset)
        constant = np.einsum("di,id->d", offset, linear)
        return self.precisions.reshape(offset.shape[0], -1).T.copy(), -2.0 * linear, constant

    @property
    def precision(self) -> FloatArray:
        """Mean precision, (shapes, shapes)."""
        fractions = np.exp(self.log_weights - logsumexp(self.log_weights))
        return np.asarray(np.einsum("d,dij->ij", fractions, self.precisions))


def known_noise(values: FloatArray, shapes: FloatArray, movements: FloatArray, error: FloatArray) -> Evidence:
    """Evidence of values with independent errors of known standard uncertainty.

    Parameters
    ----------
    values, error : (places,) arrays
    shapes : (places, shapes) array
    movements : (places, movements) array
    """
    weight = 1.0 / error**2
    centre, precision, rest = _eliminated(weight, values, shapes, movements)
    deviation, count = float(np.median(error)), values.size - movements.shape[1]
    return Evidence(np.zeros(1), centre[None], precision[None], float("inf"), deviation, rest, count)


def _eliminated(
    weight: FloatArray, values: FloatArray, shapes: FloatArray, movements: FloatArray
) -> tuple[FloatArray, FloatArray, float]:
    """Generalised least squares in coordinates where the covariance is diagonal, `movements` eliminated.

    Returns
    -------
    centre, precision : arrays
        Of the amounts of shapes.
    squares : float
        Least sum of weighted squares.
    """
    count = shapes.shape[1]
    every = np.column_stack([shapes, movements])
    normal = every.T @ (weight[:, None] * every)
    right = every.T @ (weight * values)
    amounts = np.asarray(np.linalg.solve(normal, right), float)
    rest = values - every @ amounts
    precision = normal[:count, :count]
    if movements.shape[1]:
        beside = normal[:count, count:]
        precision = precision - beside @ np.linalg.solve(normal[count:, count:], beside.T)
    return amounts[:count], 0.5 * (precision + precision.T), float(weight @ rest**2)


@dataclass(frozen=True)
class FlankNoise:
    """A measured flank on a grid without holes, from which its noise is estimated.

    Attributes
    ----------
    profile, face : (P,), (F,) arrays [mm]
        Places of rows and columns.
    values : (P, F) array
    shapes : (P, F, shapes) array
    movements : (P, F, movements) array
    """

    profile: FloatArray
    face: FloatArray
    values: FloatArray
    shapes: FloatArray
    movements: FloatArray

    def limits(self) -> tuple[FloatArray, FloatArray]:
        """Logarithms of the shortest and the longest correlation length along both directions, (2,)."""
        extents = np.array([float(np.ptp(places)) for places in (self.profile, self.face)])
        steps = extents / np.array([self.profile.size - 1, self.face.size - 1])
        return np.log(SHORTEST * steps), np.log(LONGEST * extents)

    def parameters(self, logits: FloatArray) -> tuple[float, FloatArray]:
        """Share c and both lengths [mm] from three numbers without bounds."""
        low, high = self.limits()
        return float(expit(logits[0])), np.exp(low + (high - low) * expit(logits[1:]))

    def conditional(self, logits: FloatArray) -> _Conditional:
        """Log density of noise parameters given the measurement, and the distribution of the amounts given both.

        Returns
        -------
        log_density : float
            Up to a constant, in the logits.
        centre : (shapes,) array
        precision : (shapes, shapes) array
            For unit deviation.
        deviation : float
        """
        share, lengths = self.parameters(logits)
        factors = [
            np.linalg.eigh(np.exp(-np.abs(place[:, None] - place) / length))
            for place, length in zip((self.profile, self.face), lengths, strict=True)
        ]
        (rows, across), (columns, along) = factors
        covariance = (1.0 - share) + share * np.clip(np.outer(rows, columns).ravel(), 0.0, None)

        def turned(array: FloatArray) -> FloatArray:
            return np.asarray(np.einsum("ji,jk...,kl->il...", across, array, along, optimize=True))

        flat = [turned(self.values).ravel()]
        for array in (self.shapes, self.movements):
            each = [turned(array[..., k]).ravel() for k in range(array.shape[-1])]
            flat.append(np.column_stack(each) if each else np.zeros((self.values.size, 0)))
        centre, precision, squares = _eliminated(1.0 / covariance, *flat)
        every = np.column_stack(flat[1:])
        _, information = np.linalg.slogdet(every.T @ (every / covariance[:, None]))
        freedom = self.values.size - every.shape[1]
        restricted = -0.5 * (np.log(covariance).sum() + information + freedom * np.log(squares))
        flat_in_parameters = np.sum(-np.logaddexp(0.0, logits) - np.logaddexp(0.0, -logits))
        return float(restricted + flat_in_parameters), centre, precision, float(np.sqrt(squares / freedom))


def unknown_noise(flank: FlankNoise, seed: int = 0) -> Evidence:
    """Evidence of a measured flank whose noise is correlated and unknown."""
    known: dict[bytes, float] = {}

    def against(logits: FloatArray) -> float:
        key = logits.tobytes()
        if key not in known:
            known[key] = -flank.conditional(np.clip(logits, -15.0, 15.0))[0]
        return known[key]

    starts = [np.array([logit, length, length]) for logit in (0.0, 2.0) for length in (-0.5, 1.0)]
    best = minimize(
        against, min(starts, key=against), method="Nelder-Mead", options={"maxfev": 200, "xatol": 0.02, "fatol": 0.02}
    ).x
    conditionals, weights = _draws_about(flank, best, _spread(against, best), np.random.default_rng(seed))
    kept = np.flatnonzero(weights > weights.max() + np.log(_NEGLIGIBLE))
    deviations = np.array([conditionals[k][3] for k in kept])
    freedom = flank.values.size - flank.shapes.shape[-1] - flank.movements.shape[-1]
    precisions = np.stack([conditionals[k][2] for k in kept]) / deviations[:, None, None] ** 2
    return Evidence(
        weights[kept],
        np.stack([conditionals[k][1] for k in kept]),
        precisions,
        float(freedom),
        float(np.exp(weights[kept] - logsumexp(weights[kept])) @ deviations),
    )


def _draws_about(
    flank: FlankNoise, best: FloatArray, spread: FloatArray, random: np.random.Generator
) -> tuple[list[_Conditional], FloatArray]:
    """Draws of the noise parameters, with their `FlankNoise.conditional`, and logarithms of their weights.

    A density far from normal, as when a length or the correlated fraction can hardly be determined, is wider than its
    curvature at the maximum suggests, and few draws about that are effective. More are drawn about the mean and
    covariance of the weighted ones, and each is weighted by the density of all proposals together (Cornuet et al.
    2012, Scand. J. Stat. 39, 798-812).
    """
    middle, spread, proposals = best, _WIDER * spread, list[Value]()
    drawn, conditionals = np.zeros((0, best.size)), list[_Conditional]()
    while True:
        proposals.append(multivariate_t(middle, spread, df=_TAIL, seed=random))
        more = np.atleast_2d(proposals[-1].rvs(_DRAWS))
        conditionals += [flank.conditional(np.clip(logits, -15.0, 15.0)) for logits in more]
        drawn = np.concatenate([drawn, more])
        proposed = logsumexp([proposal.logpdf(drawn) for proposal in proposals], axis=0)
        weights = np.array([conditional[0] for conditional in conditionals]) - proposed
        weights -= logsumexp(weights)
        if len(proposals) > 1 and (_effective(weights) >= _ENOUGH or len(proposals) == _ROUNDS):
            return conditionals, weights
        # a few heavy draws give no covariance: weights are evened out until they do
        even = weights
        while _effective(even) < _LEAST_EFFECTIVE:
            even = 0.5 * even
            even -= logsumexp(even)
        fraction = np.exp(even)
        middle = fraction @ drawn
        spread = _WIDER * (drawn - middle).T @ (fraction[:, None] * (drawn - middle)) + _STEP**2 * np.eye(best.size)


def _effective(log_weights: FloatArray) -> float:
    """Equivalent number of draws of equal weight; the weights sum to one."""
    return float(np.exp(-logsumexp(2.0 * log_weights)))


def _spread(function, at: FloatArray) -> FloatArray:  # type: ignore[no-untyped-def]
    """Covariance of draws: the inverse of the curvature at a minimum, limited in width."""
    count = at.size
    curvature = np.empty((count, count))
    unit = _STEP * np.eye(count)
    middle = function(at)
    for i in range(count):
        for j in range(i + 1):
            corners = [function(at + a * unit[i] + b * unit[j]) for a in (1, -1) for b in (1, -1)]
            if i == j:
                curvature[i, i] = (function(at + unit[i]) - 2.0 * middle + function(at - unit[i])) / _STEP**2
            else:
                curvature[i, j] = curvature[j, i] = (corners[0] - corners[1] - corners[2] + corners[3]) / (
                    4.0 * _STEP**2
                )
    values, vectors = np.linalg.eigh(curvature)
    variances = 1.0 / np.clip(values, 1.0 / _WIDEST, None)
    return np.asarray((vectors * variances) @ vectors.T)
