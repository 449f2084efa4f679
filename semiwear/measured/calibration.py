"""The wear coefficient from measured wear: `calibrate`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import exp, sqrt

import numpy as np
import xarray as xr

from semiwear.arrays import FloatArray
from semiwear.compliance.blas_threads import one_blas_thread
from semiwear.errors import ConvergenceError, SceneError
from semiwear.life import hours_per_mesh, step_lengths_to
from semiwear.measured.comparison import comparison_of_fit
from semiwear.measured.fit import PartFit, datum_modes, fit_part, half_interval, weighted_meshes
from semiwear.measured.life_spread import MOST_SCATTER, LifeSpread, log_deviation
from semiwear.measured.predicted import WearFamily, reading_of, wear_family
from semiwear.measured.rigid import DATUM, TURNS, require_motions
from semiwear.measured.worn import Measured, MeasuredWear, as_wear
from semiwear.meshing.flank_pair import BODIES
from semiwear.plain_text import folded, one_of, table
from semiwear.scene import BodyCoefficients, Scene
from semiwear.scene.values import shown
from semiwear.simulate import NoProgress, Progress
from semiwear.untyped import Value

_UM = 1e3
_STEPS = 16  # wear steps to the measured depth, about: their error in k is then 0.5 % at most
_DEPTHS = (0.25e-3, 6e-3)  # mm, wear of one step
_MOST_STEPS = 60
_DEFAULT_SCATTER = 0.5  # coefficient of variation of k: see semiwear.measured.life_spread
_HEAD = ("part", "k [mm2/N]", "interval", "unexplained", "rms [um]", "points", "independent", "datum")


@dataclass(frozen=True)
class Calibration:
    """A wear coefficient from measured wear: printed as a table.

    Attributes
    ----------
    scene : Scene
    body : str
        Body of the measured flank.
    meshes : tuple of float
        Engagements of one gear tooth that each part had run.
    parts : tuple of PartFit
        Fit of each measured part, at the scene's wear coefficient.
    confidence : float
        Confidence level of the intervals.
    measured : tuple of MeasuredWear
        Measured wear of each part.
    family : WearFamily
        Predicted wear over the meshes.
    """

    scene: Scene
    body: str
    meshes: tuple[float, ...]
    parts: tuple[PartFit, ...]
    confidence: float
    measured: tuple[MeasuredWear, ...]
    family: WearFamily

    @property
    def coefficients(self) -> tuple[float, ...]:
        """Wear coefficient of the measured body from each part [mm2/N]."""
        return tuple(self._own * part.meshes / run for part, run in zip(self.parts, self.meshes, strict=True))

    @property
    def coefficient(self) -> float:
        """Wear coefficient [mm2/N]: geometric mean over the parts, the median of its distribution."""
        return exp(float(np.mean(np.log(self.coefficients))))

    @property
    def factor(self) -> float:
        """`coefficient` over that of the scene; where both bodies wear, both coefficients have the same factor."""
        return self.coefficient / self._own

    @property
    def log_error(self) -> float:
        """Standard uncertainty of ln k: from the fit of a single part, or of the mean over several parts."""
        if len(self.parts) == 1:
            return self.parts[0].log_error
        return self._log_scatter / sqrt(len(self.parts))

    @property
    def interval(self) -> tuple[float, float]:
        """Confidence interval of the wear coefficient [mm2/N], by Student's t for ln k.

        With one part: from the uncertainty of its measurement, without the scatter between parts. With several: of
        their mean, from the scatter between them.
        """
        freedom = self.parts[0].freedom if len(self.parts) == 1 else len(self.parts) - 1.0
        half = half_interval(self.log_error, freedom, self.confidence)
        return self.coefficient * exp(-half), self.coefficient * exp(half)

    @property
    def k_scatter(self) -> float | None:
        """Coefficient of variation of k between the parts (log-normal); None for one part."""
        if len(self.parts) == 1:
            return None
        return sqrt(exp(self._log_scatter**2) - 1.0)

    @property
    def calibrated_scene(self) -> Scene:
        """The scene with this wear coefficient."""
        wear = self.scene.wear
        assert wear is not None
        given = wear.coefficient_mm2_per_N
        if isinstance(given, BodyCoefficients):
            scaled = {name: self.factor * k for name, k in given.given.items()}
            return self.scene.replace({"wear.coefficient_mm2_per_N": scaled})
        return self.scene.replace({"wear.coefficient_mm2_per_N": self.factor * given})

    def comparison(self, part: int = 0) -> xr.Dataset:
        """Predicted and measured wear of a part, as from `compare_wear`, at the part's own coefficient."""
        run = f"{self.meshes[part]:.6g}"
        attrs = {"body": self.body, "meshes": run, "datum": ", ".join(self.parts[part].datum)}
        return comparison_of_fit(self.measured[part], self.parts[part], attrs)

    @one_blas_thread()
    def life(
        self, depth_limit_um: float, body: str | None = None, *, k_scatter: float | str = _DEFAULT_SCATTER
    ) -> LifeSpread:
        """Life until the greatest wear of a flank reaches a depth, with the uncertainty of the wear coefficient.

        Parameters
        ----------
        depth_limit_um : float
        body : str, optional
            ``"pinion"`` or ``"gear"``; default the measured body. The coefficient of the other body is scaled by the
            same factor.
        k_scatter : float or "measured"
            Coefficient of variation of k from part to part. Default 0.5, an assumption
            (`semiwear.measured.life_spread`); 0 gives the life of the measured part itself. ``"measured"`` takes that
            of the parts, three or more.

        Raises
        ------
        SceneError
            For a depth, body or scatter out of range.
        ConvergenceError
            If the flank cannot be worn so deep.
        """
        if not 0.0 < depth_limit_um < np.inf:
            raise SceneError.of("depth_limit_um", depth_limit_um, "above 0 um")
        wear = self.scene.wear
        assert wear is not None
        name = self.body if body is None else body
        if name not in wear.worn_bodies:
            raise SceneError.of("body", name, one_of(wear.worn_bodies))
        count = len(self.parts)
        if k_scatter == "measured":
            if count < 3:
                raise SceneError.of("k_scatter", k_scatter, "a number, with fewer than three parts", "0.5 is usual")
            deviation = self._log_scatter * sqrt(1.0 + 1.0 / count)
            scatter, freedom = self.k_scatter or 0.0, count - 1.0
        else:
            if isinstance(k_scatter, str) or not 0.0 <= k_scatter <= MOST_SCATTER:
                allowed = f'a share, 0 to {MOST_SCATTER:g}, or "measured"'
                raise SceneError.of("k_scatter", shown(k_scatter), allowed, "0.5 for 50 %")
            fits = sum(part.log_error**2 for part in self.parts) / count**2
            between = log_deviation(k_scatter)
            deviation, scatter, freedom = sqrt(between**2 * (1.0 + 1.0 / count) + fits), k_scatter, float("inf")
        stepper = self.family.stepper
        meshes = sum(step_lengths_to(stepper, BODIES.index(name), 1e-3 * depth_limit_um))
        per_mesh = hours_per_mesh(self.scene, stepper.teeth.pair)
        return LifeSpread(name, depth_limit_um, meshes / self.factor, deviation, freedom, scatter, per_mesh)

    def to_dataset(self) -> xr.Dataset:
        """`coefficient` and `interval` [mm2/N], and the results of each part."""
        run = {"units": "1", "long_name": "engagements of one gear tooth"}
        k = {"units": "mm2 N-1", "long_name": f"wear coefficient of the {self.body}"}

        def of_parts(value: Callable[[PartFit], float], units: str) -> tuple[str, FloatArray, dict[str, str]]:
            return "part", np.array([value(part) for part in self.parts]), {"units": units}

        return xr.Dataset(
            {
                "coefficient": ((), self.coefficient, k),
                "interval": ("end", np.array(self.interval), k),
                "part_coefficient": ("part", np.array(self.coefficients), k),
                "log_uncertainty": of_parts(lambda part: part.log_error, "1"),
                "meshes": ("part", np.array(self.meshes), run),
                "explained": of_parts(lambda part: part.explained, "1"),
                "residual_rms": of_parts(lambda part: _UM * part.residual_rms, "um"),
                "points": of_parts(lambda part: part.points, "1"),
                "effective_points": of_parts(lambda part: part.effective_points, "1"),
                "correlation_length_profile": of_parts(lambda part: part.noise.correlation.profile_length, "mm"),
                "correlation_length_face": of_parts(lambda part: part.noise.correlation.face_length, "mm"),
            },
            {"end": ["low", "high"], "part": np.arange(len(self.parts))},
            {"title": "wear coefficient from measured wear", "body": self.body, "confidence": self.confidence},
        )

    def __str__(self) -> str:
        low, high = self.interval
        share = f"{100.0 * self.confidence:g} %"
        count = len(self.parts)
        basis = "one part: without the scatter between parts" if count == 1 else f"{count} parts"
        scatter = f"; k scatters by {100.0 * self.k_scatter:.0f} % between the parts" if self.k_scatter else ""
        summary = (
            f"wear coefficient of the {self.body}: {self.coefficient:.3e} mm2/N, {share} interval {low:.3e} to "
            f"{high:.3e} ({basis}); the scene has {self._own:.3e} mm2/N{scatter}"
        )
        return folded(summary) + "\n\n" + table(_HEAD, [self._row(k) for k in range(count)])

    @property
    def _own(self) -> float:
        assert self.scene.wear is not None
        return self.scene.wear.coefficient(self.body)

    @property
    def _log_scatter(self) -> float:
        """Standard deviation of ln k between several parts."""
        return float(np.std(np.log(self.coefficients), ddof=1))

    def _row(self, number: int) -> tuple[str, ...]:
        part, k = self.parts[number], self.coefficients[number]
        low, high = (self._own * meshes / self.meshes[number] for meshes in part.interval(self.confidence))
        datum = ", ".join(f"{name} {_with_unit(name, amount)}" for name, amount in part.datum.items())
        return (
            str(number + 1),
            f"{k:.3e}",
            f"{low:.2e} to {high:.2e}",
            f"{100.0 * (1.0 - part.explained):.1f} %",
            f"{_UM * part.residual_rms:.2f}",
            str(part.points),
            f"{part.effective_points:.0f}",
            datum or "-",
        )


def _with_unit(name: str, amount: float) -> str:
    """Amount of a motion in arcsec or um, as text."""
    if name in TURNS:
        return f"{np.degrees(amount) * 3600.0:.2f} arcsec"
    return f"{_UM * amount:.2f} um"


@one_blas_thread()
def calibrate(
    scene: Scene,
    measured: Measured | Sequence[Measured],
    *,
    meshes: float | Sequence[float] | None = None,
    body: str = "gear",
    before: Measured | Sequence[Measured] | None = None,
    datum: Sequence[str] = DATUM,
    robust: bool = False,
    confidence: float = 0.95,
    progress: Progress | None = None,
) -> Calibration:
    """The wear coefficient for which predicted wear equals measured wear, with its confidence interval.

    The scene is run once, from the unworn flank, until the predicted wear exceeds the measured wear. Wear depends on
    the product of coefficient and meshes, so that this run gives the prediction for every coefficient. Fit and
    uncertainty: `semiwear.measured.fit`. The interval covers the uncertainty of the measurement, and errors of the
    model as far as they show in the residuals. Errors of the resolution come on top, to be found by a finer run (from
    the wear steps: some tenths of a per cent).

    Parameters
    ----------
    scene : Scene
        With a table [wear]; its coefficient is a first guess. The ratio of the coefficients of both bodies is kept.
        ``numerics.accuracy`` is ignored.
    measured : measurement or list of them
        Each part as for `measured_wear`: a file or array of points, deviations, or a dataset of `register` or
        `measured_wear`. Several parts give the scatter of k from part to part.
    meshes : float or sequence, optional
        Engagements of one gear tooth that the parts have run; default ``wear.until.meshes``.
    body : str
        Body of the measured flank.
    before : measurement or list, optional
        Each part before it was worn; default nominal.
    datum : sequence of str
        Motions of the measured tooth that are fitted with the wear: as the `motions` of `register`; () for none.
    robust : bool
        Least squares with Huber's weights, for outliers. Default False.
    confidence : float
        Confidence level of the intervals. Default 0.95.
    progress : Progress, optional
        Notified of every wear step.

    Raises
    ------
    SceneError
        For measurements that cannot be read or registered, missing meshes, or measured wear from which the
        coefficient cannot be determined.
    ConvergenceError
        If the scene cannot be worn as deep as was measured.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import semiwear as sw
    >>> coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.wear_steps": 2}
    >>> scene, path = sw.load_scene("spur_fzg_c").replace(coarse), pathlib.Path(tempfile.mkdtemp(), "worn.nc")
    >>> sw.export_flank(scene, "gear", path, points=(31, 9), worn=sw.simulate(scene))
    >>> found = sw.calibrate(scene, path, meshes=scene.wear.until.meshes)
    >>> print(f"{found.coefficient / 1e-13:.1f}")  # worn with 1e-13 mm2/N
    1.0
    """
    if not 0.0 < confidence < 1.0:
        raise SceneError.of("confidence", confidence, "above 0 and below 1", "0.95 for 95 %")
    motions = require_motions(datum, "datum")
    parts = _listed(measured)
    unworn = [None] * len(parts) if before is None else _listed(before)
    if not parts or len(unworn) != len(parts):
        found = f"{len(parts)} measured parts, {len(unworn)} before"
        raise SceneError.of("measured", found, "one part or more, and as many before", "give them in the same order")
    run = _meshes_run(scene, meshes, len(parts))
    names = [f"measured[{k}]" if len(parts) > 1 else "measured" for k in range(len(parts))]
    worn = [
        as_wear(scene, part, new, body, datum="best_fit" if motions else "as_measured", field=name)
        for part, new, name in zip(parts, unworn, names, strict=True)
    ]
    depth = max(_spread(part, motions) for part in worn)
    family = wear_family(scene, body, float(np.clip(depth / _STEPS, *_DEPTHS)))
    assumed = "" if before is not None else _assumed_unworn(scene, body)
    try:
        _wear_past(family, worn, motions, progress or NoProgress(), assumed, robust=robust)
        fits = tuple(
            fit_part(
                family.curve(reading_of(family, part)), part, motions,
                robust=robust, confidence=confidence, field=name,
            )
            for part, name in zip(worn, names, strict=True)
        )  # fmt: skip
    except SceneError as error:
        raise SceneError([replace(each, fix=f"{each.fix}{assumed}") for each in error.problems]) from None
    return Calibration(scene, body, run, fits, confidence, tuple(worn), family)


def _assumed_unworn(scene: Scene, body: str) -> str:
    """Assumption about the unworn flank where it was not measured, as the end of a message."""
    table = f"effects.modification.{body}"
    if scene.effects.get(f"modification.{body}") is None:
        return f". Without before, the unworn flank is assumed nominal: give before, or [{table}] if it was modified"
    return (
        f". Without before, the unworn flank is assumed to be modified as in [{table}]: give before, or remove that "
        "table if the measured flank is not modified (export_flank writes no modifications)"
    )


def _listed(measured: object) -> list[Value]:
    """Measured parts as a list, also a single part."""
    if isinstance(measured, list | tuple) and not _is_points(measured):
        return list(measured)
    return [measured]


def _is_points(measured: Sequence[object]) -> bool:
    """Whether nested lists are the points of one part rather than a list of parts."""
    first = measured[0] if measured else None
    while isinstance(first, list | tuple) and first:
        first = first[0]
    return isinstance(first, int | float)


def _meshes_run(scene: Scene, meshes: float | Sequence[float] | None, count: int) -> tuple[float, ...]:
    given = meshes
    if given is None and scene.wear is not None:
        given = scene.wear.until.meshes
    if given is None:
        raise SceneError.of(
            "meshes", None, "above 0", "give the engagements of a gear tooth that the parts have run (meshes=...)"
        )
    run = np.full(count, given, float) if np.ndim(given) == 0 else np.asarray(given, float)
    if run.shape != (count,) or not np.all(np.isfinite(run)) or np.any(run <= 0.0):
        allowed = "a number above 0" + (f", or {count} of them" if count > 1 else "")
        fix = "one for each measured part, or one for all" if count > 1 else "engagements of a gear tooth"
        raise SceneError.of("meshes", given, allowed, fix)
    return tuple(map(float, run))


def _spread(part: MeasuredWear, motions: tuple[str, ...]) -> float:
    """Range of measured wear over the flank, independent of the datum [mm]."""
    _, modes = datum_modes(part, motions)
    wear, inside_modes = part.depth[part.inside], modes[part.inside]
    rest = wear - inside_modes @ np.linalg.lstsq(inside_modes, wear, rcond=None)[0]
    low, high = np.percentile(rest, (2.0, 98.0))
    return float(high - low)


def _wear_past(
    family: WearFamily,
    worn: Sequence[MeasuredWear],
    motions: tuple[str, ...],
    progress: Progress,
    assumed: str = "",
    *,
    robust: bool = False,
) -> None:
    """Add wear steps until the best fit of every part lies well before the end of the run, with its own weights.

    Raises
    ------
    ConvergenceError
        If the flank cannot be worn so far.
    """
    readings = [reading_of(family, part) for part in worn]
    modes = [datum_modes(part, motions)[1][part.inside] for part in worn]
    for k in range(1, _MOST_STEPS + 1):
        family.extend()
        progress.step(k, _MOST_STEPS, f"{_UM * family.greatest:.3g} um at most, {family.meshes[-1]:.3g} meshes")
        if k < 3:
            continue
        passed = []
        for part, reading, mode in zip(worn, readings, modes, strict=True):
            meshes, *_ = weighted_meshes(family.curve(reading), part, mode, robust)
            passed.append(meshes < 0.8 * family.meshes[-1])
        if all(passed):
            progress.step(k, k, "worn deeper than measured")
            return
    raise ConvergenceError(
        f"wear of {_UM * family.greatest:.3g} um at most is still less than the measured wear: check the "
        f"measurement's units and body, or give the datum fewer motions{assumed}"
    )
