"""Fit of predicted to measured wear: the meshes at which both agree, together with the datum.

Measured wear at the points is w = h(N) + M a + e: h the predicted wear after N meshes at the scene's wear
coefficient, M the displacement of the flank along its normals by unit motions of the datum, a the amounts of these
motions, e the residuals. Least squares over ln N and a, with the linear a eliminated at every N (Golub and Pereyra
1973, SIAM J. Num. Anal. 10, 413-432). The wear coefficient is that of the scene, times N over the meshes that the
part has run. The uncertainty of ln N accounts for the correlation of neighbouring residuals
(`semiwear.measured.correlated`), which contain the errors of the model.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from scipy.optimize import minimize_scalar

from semiwear.arrays import FloatArray
from semiwear.errors import SceneError
from semiwear.measured.correlated import Estimate, estimate
from semiwear.measured.predicted import WearCurve
from semiwear.measured.rigid import determined, motions_of, require_motions
from semiwear.measured.robust import huber_loss, huber_weights, local_noise, weighted_fit
from semiwear.measured.worn import MeasuredWear

_SHORTEST = 1e-4  # of the meshes of the curve: start of the search
_TRIALS = 80
_PASSES = 12  # iterations of the robust weights
_START_PASSES = 5  # the same for each trial of the start
_END = 0.01  # distance in ln N to the end of the curve: a minimum closer to it is no best fit
_UM = 1e3


@dataclass(frozen=True)
class PartFit:
    """Fit of one measured part.

    Attributes
    ----------
    meshes : float
        N, meshes at the scene's coefficient.
    log_error : float
        Standard uncertainty of ln N.
    freedom : float
        Degrees of freedom of this uncertainty.
    datum : mapping of str to float [rad, mm]
        Fitted motions of the measurement, with the sign of wear: positive removes material.
    residual : (P, F) array [mm]
        Measured wear less predicted wear and the datum's part; 0 where not inside.
    predicted : (P, F) array [mm]
    aligned : (P, F) array [mm]
        Measured wear less the datum's part.
    explained : float
        Fraction of the measured variance about the datum's part that predicted wear explains.
    effective_points : float
        Number of independent points that would give the same uncertainty of ln N.
    points : int
    noise : Estimate
    """

    meshes: float
    log_error: float
    freedom: float
    datum: dict[str, float]
    residual: FloatArray
    predicted: FloatArray
    aligned: FloatArray
    explained: float
    effective_points: float
    points: int
    noise: Estimate

    @property
    def residual_rms(self) -> float:
        """Root mean square of the residuals [mm]."""
        return float(np.sqrt(np.sum(self.residual**2) / self.points))

    def interval(self, confidence: float) -> tuple[float, float]:
        """Confidence interval of N, in meshes."""
        half = half_interval(self.log_error, self.freedom, confidence)
        return self.meshes * float(np.exp(-half)), self.meshes * float(np.exp(half))


def half_interval(error: float, freedom: float, confidence: float) -> float:
    """Half-width of a confidence interval from a standard uncertainty, by Student's t."""
    return float(scipy.stats.t.ppf(0.5 + 0.5 * confidence, freedom)) * error


def datum_modes(measured: MeasuredWear, motions: Sequence[str]) -> tuple[tuple[str, ...], FloatArray]:
    """Motions that a measurement determines, and displacements of its points along the normals into the flank.

    Returns
    -------
    names : tuple of str
    modes : (P, F, motions) array [mm/rad or 1]

    Raises
    ------
    SceneError
        For unknown motions.
    """
    points, normals = measured.flank.points(measured.face, measured.profile)
    candidates = motions_of(measured.flank, require_motions(motions, "datum"))
    modes = -candidates.modes(points, normals)
    kept = determined(modes[measured.inside])
    return tuple(name for name, keep in zip(candidates.names, kept, strict=True) if keep), modes[..., kept]


def best_meshes(curve: WearCurve, wear: FloatArray, modes: FloatArray, weights: FloatArray) -> tuple[float, bool]:
    """Meshes at which predicted wear fits best, and whether they lie within the curve.

    Parameters
    ----------
    curve : WearCurve
        Predicted wear at the points.
    wear : (points,) array [mm]
    modes : (points, motions) array
    weights : (points,) array
    """
    root, without_modes = np.sqrt(weights), _without_modes(modes, weights)
    target = without_modes(root * wear)

    def squares(log_meshes: float) -> float:
        rest = target - without_modes(root * curve.at(float(np.exp(log_meshes))))
        return float(rest @ rest)

    last = float(np.log(curve.meshes[-1]))
    trials = np.linspace(last + np.log(_SHORTEST), last, _TRIALS)
    values = [squares(trial) for trial in trials]
    best = int(np.argmin(values))
    if best in (0, _TRIALS - 1):
        return float(np.exp(trials[best])), False
    bounds = (trials[best - 1], trials[best + 1])
    found = minimize_scalar(squares, bounds=bounds, method="bounded", options={"xatol": 1e-9})
    return float(np.exp(found.x)), float(found.x) < last - _END


def weighted_meshes(
    curve: WearCurve, measured: MeasuredWear, modes: FloatArray, robust: bool
) -> tuple[float, bool, FloatArray]:
    """As `best_meshes`, with the weights of the points: Huber's if the fit is robust, otherwise 1.

    Parameters
    ----------
    curve : WearCurve
    measured : MeasuredWear
    modes : (points, motions) array
        At the points inside.
    robust : bool
    """
    wear = measured.depth[measured.inside]
    if not robust:
        weights = np.ones(wear.size)
        return (*best_meshes(curve, wear, modes, weights), weights)
    weights = _robust_start(curve, wear, modes, local_noise(measured.depth, measured.inside))
    meshes, within = best_meshes(curve, wear, modes, weights)
    for _ in range(_PASSES):
        rest = wear - curve.at(meshes)
        amounts = weighted_fit(modes, rest, weights)
        weights = huber_weights(rest - modes @ amounts, np.ones(wear.size, dtype=bool))
        before = meshes
        meshes, within = best_meshes(curve, wear, modes, weights)
        if abs(np.log(meshes / before)) < 1e-8:
            break
    return meshes, within, weights


def _robust_start(curve: WearCurve, wear: FloatArray, modes: FloatArray, noise: float) -> FloatArray:
    """Weights at the least Huber loss over trial meshes: a start from unit weights may follow an outlier."""
    every = np.ones(wear.size, dtype=bool)
    best, least = np.ones(wear.size), np.inf
    for meshes in curve.meshes[-1] * np.geomspace(_SHORTEST, 1.0, _TRIALS):
        rest, weights = wear - curve.at(meshes), np.ones(wear.size)
        for _ in range(_START_PASSES):
            residual = rest - modes @ weighted_fit(modes, rest, weights)
            weights = huber_weights(residual, every, noise)
        loss = huber_loss(residual, noise)
        if loss < least:
            best, least = weights, loss
    return best


def _without_modes(modes: FloatArray, weights: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """Projection of weighted values orthogonal to the weighted modes."""
    basis = np.linalg.qr(np.sqrt(weights)[:, None] * modes)[0]
    return lambda values: np.asarray(values - basis @ (basis.T @ values))


def fit_part(
    curve: WearCurve,
    measured: MeasuredWear,
    motions: tuple[str, ...],
    *,
    robust: bool = False,
    confidence: float = 0.95,
    field: str = "measured",
) -> PartFit:
    """Fit of a part: predicted wear of a curve to its measured wear.

    Raises
    ------
    SceneError
        If the measured wear does not determine the wear coefficient: it is within the noise, or of another shape.
    """
    inside = measured.inside
    names, modes = datum_modes(measured, motions)
    flat, wear = modes[inside], measured.depth[inside]
    meshes, within, weights = weighted_meshes(curve, measured, flat, robust)
    predicted = curve.at(meshes)
    amounts = weighted_fit(flat, wear - predicted, weights)
    rest = wear - predicted - flat @ amounts
    derivatives = np.column_stack([curve.slope(meshes), flat])
    at_start = meshes <= 2.0 * _SHORTEST * curve.meshes[-1] or not np.any(derivatives[:, 0])
    if at_start or not within:
        _no_information(rest, predicted, np.inf, field)
    on_grid = measured.on_grid
    noise = estimate(on_grid(rest), on_grid(derivatives), on_grid(weights), *measured.places)
    error = float(noise.errors[0])
    if half_interval(error, noise.freedom, confidence) >= 1.0:
        _no_information(rest, predicted, error, field)
    without_datum = _without_modes(flat, weights)(np.sqrt(weights) * wear)
    total = float(without_datum @ without_datum)
    return PartFit(
        meshes=meshes,
        log_error=error,
        freedom=noise.freedom,
        datum=dict(zip(names, map(float, amounts), strict=True)),
        residual=on_grid(rest),
        predicted=on_grid(predicted),
        aligned=on_grid(wear - flat @ amounts),
        explained=1.0 - float(np.sum(weights * rest**2)) / total if total > 0.0 else 0.0,
        effective_points=float(noise.effective_points[0]),
        points=int(inside.sum()),
        noise=noise,
    )


def _no_information(rest: FloatArray, predicted: FloatArray, error: float, field: str) -> None:
    noise, depth = _UM * float(np.sqrt(np.mean(rest**2))), _UM * float(np.ptp(predicted))
    uncertain = "" if not np.isfinite(error) else f", so that k would be uncertain by {100.0 * error:.0f} %"
    raise SceneError.of(
        field,
        f"wear that does not determine k: the predicted wear that fits best varies by {depth:.2g} um over the flank, "
        f"the residual scatters by {noise:.2g} um{uncertain}",
        "wear of the predicted shape above the noise",
        "measure after more meshes, with less noise or on more of the flank, or check body, flank and scene",
    )
