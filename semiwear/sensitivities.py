"""Sensitivities: derivatives of quantities of worn flanks with respect to the fields of a scene.

Each field is moved by a step to either side while the rest of the run is unchanged: its grids, its number of wear
steps, and the compliance and contact lines that it shares with the scene. All runs are smooth ones (`Compared`):
otherwise edges that press on a flank yield in steps of a cell, by which wear jumps by some 2e-4 every few
thousandths of a load. The slope between two jumps is not the derivative, nor is that over a few of them; both were
wrong by a tenth. Every slice that comes into contact would make a kink, too, as great as the derivatives of a tooth
that is slightly misaligned. Where slopes to either side are nearly the same, the central difference d(h) is the
derivative: the error of a smooth quantity is then a small part of the difference of the slopes, that of a quantity
that scatters about a line 0.29 of it (independent errors of the three values), and that of a kink within a step half
of it, which is the reported error.

Where they are not, the field is moved by two steps, first to one side: if slopes change evenly over the three steps,
the derivative is that of the cubic through all four values, its error the difference from d(h). If they do not, the
field is moved to the other side, too. If slopes change evenly over all four steps (Richardson 1911, Phil. Trans. R.
Soc. A 210, 307-357)

    d = [4 d(h) - d(2h)] / 3,    error |d(h) - d(2h)| / 3.

Across a kink they do not, wherever in a step it lies. Then, and where values scatter, the error is half of the
difference of slopes to either side, plus a twelfth of its change from a step to the next.

Steps are as short as the scatter of smooth runs allows. Where the contact set changes or a tip edge comes into
contact there is a kink or a small jump, and the longer a step, the more of these lie within it.

The runs of one field share their prisms: these are computed a tenth of a step beside the scene, and interpolated
linearly through both. The remaining scatter between smooth runs and small kinks are part of every error: 5e-10 of a
value (most fields change smooth runs evenly to 1e-12, those of a helical pair's geometry to 1e-9; runs of face gear
pairs whose tip edges are in contact jump by more, which shows in the slopes to either side) and 2e-3 of the
derivative. The latter is fitted to nine random scenes (`validation.gradients`), 95 % of whose derivatives were within
their error with steps ten times as long.

Wear depends on the product of its coefficient and the number of meshes. To control depths, and for a life,
derivatives with respect to the coefficient are therefore known without a run; in a run to a number of meshes the
coefficient and that number share their runs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import xarray as xr

from semiwear.errors import Problem, SceneError, SemiwearError
from semiwear.optimise.quantity import Quantity, measure_of_quantities, quantity_of, unmet_needs
from semiwear.optimise.space import scene_value
from semiwear.plan import Compared
from semiwear.results.provenance import version
from semiwear.scene import Scene
from semiwear.scene.edit import unknown_field
from semiwear.scene.rating_tables import RatingTable
from semiwear.scene.values import is_number, is_whole, shown
from semiwear.simulate import Progress, wear_problems
from semiwear.sweep.assemble import INVERSE_TO_COEFFICIENT
from semiwear.sweep.bar import progress_receiver
from semiwear.sweep.measure import MESHES, Measure
from semiwear.sweep.outcome import Outcome, Status, solve
from semiwear.sweep.processes import Crew
from semiwear.sweep.scenes import Task, shared_by, shared_solution
from semiwear.sweep.settled import settled
from semiwear.threads import available_threads

_STEP = 2e-4  # of a field's value
_NEAR, _AHEAD = (-1, 1), 2  # steps
_SIDES = (*_NEAR, _AHEAD, -_AHEAD)
_BESIDE = 0.1  # of a step: position of the second set of prisms, for interpolation
_MOST_FIELDS = 30
_KINK = 0.05  # of the derivative: least difference of slopes to either side that is reported
_STRAIGHT = 0.02  # of the derivative: with less difference of slopes to either side no second pair of runs is needed
_EVEN = 0.25  # of the difference of slopes to either side: its change to the next step
_EVEN_AHEAD = 0.1  # of the same, if only one side is known, where a kink in the middle of a step looks even
_KINKED = 0.5  # of the difference: error of a central difference if all of it is a kink within a step
_BEYOND = 1.0 / 12.0  # of its change to the next step: error by a kink beyond the first steps
_SCATTER = 5e-10  # of a value: scatter between smooth runs, if a field hardly changes it
_LEAST_ERROR = 2e-3  # of a derivative: for small kinks within a step; fitted
_DOUBTFUL = 0.01  # of the derivative
_NO_CHANGE = 1e-9  # of a quantity: with less change it does not depend on the field
_SLIGHT = 1e-4  # relative change of a quantity over that of a field: less does not matter
_COEFFICIENT, _MESHES_RUN = "wear.coefficient_mm2_per_N", "wear.until.meshes"


def sensitivities(
    scene: Scene,
    of: str | Sequence[str],
    to: Sequence[str] | Mapping[str, float],
    *,
    workers: int | None = None,
    progress: Progress | bool | None = None,
) -> xr.Dataset:
    """Derivatives of quantities of worn flanks with respect to fields of a scene.

    Parameters
    ----------
    scene : Scene
        It needs a table ``[wear]``.
    of : str or sequence of str
        Variables of `/history` or `/life`, such as ``"wear_depth_max"`` or ``"root_stress_max[pinion, worst]"``: as
        in `optimise`.
    to : sequence of str, or mapping
        Dotted keys of up to 30 fields that are numbers; a mapping gives the step of each, in the field's unit.
        Default step: 2e-4 of the value.
    workers : int, optional
        Processes, this one among them; 0: in this one, with all its threads. Default: one per core.
    progress : Progress or bool, optional
        Called after every run; True shows a bar (extra ``progress``).

    Returns
    -------
    Dataset
        Along `quantity` and `field`: `derivative` in units of the quantity over that of the field, its `error`,
        `relative` (change of the quantity over that of the field, both relative), `kink` where slopes to either side
        differ, `doubtful` where there is a kink or the error is above 1 % of the derivative, unless both are below
        1e-4 in `relative`; NaN, with its reason in `message` along `field`, where neither side can be solved. Along
        `quantity`: `value` in the scene and `units`. Along `field`: `field_value` in the scene, `step`, and `runs`,
        the number of scenes solved for it.

    Raises
    ------
    SceneError
        With all faults of the arguments, before anything runs; after the scene's own run, if its result does not have
        a quantity.
    SemiwearError
        The scene itself cannot be solved.

    Notes
    -----
    `value` and derivatives are those of the smooth run; `simulate` differs from it by some 0.1 %, mostly in wear
    depths. At fidelity ``patch`` edges and contacts are treated as in an ordinary run: only wear steps are smoothed,
    and the tolerances of iterations are tighter.

    It takes one run, and two for each field: three if the first two show a bend, four if that is a kink or scatter,
    none for the wear coefficient if runs end at depths.

    With ``numerics.accuracy`` the numerics are chosen once; all runs then use them, with as many plain wear steps as
    the accurate run had, and `value` is theirs.

    Examples
    --------
    >>> import semiwear as sw
    >>> coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.wear_steps": 1}
    >>> scene = sw.load_scene("spur_fzg_c").replace({"wear.until.meshes": 1e6} | coarse)
    >>> slopes = sw.sensitivities(scene, "wear_depth_max", ["wear.coefficient_mm2_per_N"], workers=0)
    >>> print(f"{float(slopes.relative[0, 0]):.1f}")  # so little wear leaves the flanks as they are
    1.0
    """
    problems: list[Problem] = []
    names = [of] if isinstance(of, str) or not isinstance(of, Sequence) else list(of)
    quantities = [found for name in names if (found := quantity_of("of", name, problems)) is not None]
    if not names:
        problems.append(Problem("of", "nothing", "one quantity or more", 'such as "wear_depth_max"'))
    problems += [one for quantity in quantities for one in unmet_needs("of", quantity, scene)]
    steps = _steps(scene, to, problems)
    problems += wear_problems(scene)
    if workers is not None and (not is_whole(workers) or workers < 0):
        problems.append(Problem("workers", shown(workers), "a whole number, 0 or more", "leave it out"))
    if problems:
        raise SceneError(problems, "sensitivities")
    measure = measure_of_quantities(quantities)
    count = available_threads() if workers is None else workers
    with progress_receiver(progress) as report, Crew(count, helped=True) as crew:
        crew.call()  # while the scene itself is solved
        runs = _Runs(crew, report, 1 + len(_NEAR) * len(steps))
        settled, base = _settled(scene, replace(measure, last=False), runs)
        _require_quantities(quantities, base)
        moved = {key: _Moved(key, float(scene_value(settled, key) or 0.0), step) for key, step in steps.items()}
        shared = _shared_with(settled, moved, quantities)
        own = [variation for key, variation in moved.items() if key not in shared]
        runs.fill(settled, base, own, _NEAR, measure)
        bent = [variation for variation in own if any(_bends(variation, quantity, base) for quantity in quantities)]
        runs.fill(settled, base, bent, (_AHEAD,), measure)
        uneven = [entry for entry in bent if any(_bends_unevenly(entry, quantity, base) for quantity in quantities)]
        runs.fill(settled, base, uneven, (-_AHEAD,), measure)
    for key, other in shared.items():
        same = moved[other]
        moved[key].found, moved[key].refused, moved[key].exact = same.found, same.refused, same.exact
    return _dataset(settled, quantities, list(moved.values()), base)


def _steps(scene: Scene, to: object, problems: list[Problem]) -> dict[str, float]:
    """Step of every field."""
    if isinstance(to, str) or not isinstance(to, Sequence | Mapping) or not to:
        fix = 'such as ["operation.pinion_torque_Nm"]'
        problems.append(Problem("to", shown(to), "a list of fields, or a mapping to their steps", fix))
        return {}
    if len(to) > _MOST_FIELDS:
        problems.append(Problem("to", len(to), f"at most {_MOST_FIELDS} fields", "take those that matter"))
    found = {}
    for key in to:
        value = scene_value(scene, str(key))
        given = to[key] if isinstance(to, Mapping) else None
        if given is not None and not (is_number(given) and given > 0.0):
            problems.append(Problem(f"to.{key}", shown(given), "a step above 0", "in the unit of the field"))
        elif (value is None and given is None) or (value is not None and not is_number(value)):
            problems.append(_no_number(scene, str(key), value))
        elif isinstance(value, int):
            fix = "take the difference of two scenes, or a sweep"
            problems.append(Problem(str(key), value, "a field that can be any number", fix))
        elif value == 0 and given is None:
            fix = f'give its step: to={{"{key}": ...}}'
            problems.append(Problem(str(key), value, "a value other than 0, or a step of its own", fix))
        else:
            found[str(key)] = float(given if given is not None else _STEP * abs(float(value)))
    return found


def _no_number(scene: Scene, key: str, value: object) -> Problem:
    unknown = unknown_field(scene, key, key)
    if unknown:
        return replace(unknown[0], field="to")
    fix = "give the scene a value, or a step in a mapping where a field that is left out counts as 0"
    return Problem(key, shown(value), "a field that is a number", fix)


@dataclass
class _Moved:
    """A field, and the runs with values to either side.

    Attributes
    ----------
    key : str
    at, step : float
    found : dict of int to Outcome
        By number of steps from the scene's value.
    refused : dict of int to str
        Reasons why there is no such scene.
    runs : int
        Scenes solved for it.
    exact : bool
        Whether no run was needed, its own or another field's.
    """

    key: str
    at: float
    step: float
    found: dict[int, Outcome] = field(default_factory=dict)
    refused: dict[int, str] = field(default_factory=dict)
    runs: int = 0
    exact: bool = True

    def values(self, quantity: Quantity) -> dict[int, float]:
        """Values of a quantity by number of steps, NaN where it has none."""
        return {side: quantity.value(outcome.measured, low_is_good=True) for side, outcome in self.found.items()}

    @property
    def slight(self) -> float:
        """Relative change of a quantity by one step that counts as zero."""
        return max(_NO_CHANGE, _SLIGHT * self.step / abs(self.at)) if self.at else _NO_CHANGE

    @property
    def message(self) -> str:
        """Reasons for missing values."""
        reasons = [*self.refused.values(), *(outcome.message for outcome in self.found.values() if outcome.message)]
        return "; ".join(dict.fromkeys(reasons))


class _Runs:
    """Solves scenes, and reports how many are done."""

    def __init__(self, crew: Crew, report: Progress, total: int) -> None:
        self._crew, self._report, self._total, self._done = crew, report, total, 0

    def one(self, scene: Scene, measure: Measure) -> Outcome:
        """The scene itself.

        Raises
        ------
        SemiwearError
            It cannot be solved.
        """
        outcome = solve(Task("", scene, measure, Compared.with_runs_of(scene)))
        self._count("the scene")
        if outcome.status is not Status.DONE:
            raise SemiwearError(f"sensitivities: the scene itself cannot be solved: {outcome.message}")
        return outcome

    def fill(
        self, scene: Scene, base: Outcome, fields: Sequence[_Moved], sides: Sequence[int], measure: Measure
    ) -> None:
        """Solve the runs of fields at the given sides."""
        tasks: list[Task] = []
        places: dict[str, tuple[_Moved, int]] = {}
        compared_runs = Compared.with_runs_of(scene)
        for variation in fields:
            beside = _beside(scene, variation)
            for side in sides:
                try:
                    changed = scene.replace({variation.key: variation.at + side * variation.step})
                except SceneError as error:
                    variation.refused[side] = "; ".join(str(problem) for problem in error.problems)
                    continue
                changed = replace(changed, title=scene.title)
                same, stretch = shared_solution(changed, scene, measure)
                if stretch != 1.0 and same == scene:
                    variation.found[side] = _stretched(base, stretch)
                    continue
                variation.runs, variation.exact = variation.runs + 1, False
                compared = compared_runs.along(scene, beside, side / _BESIDE)
                tasks.append(Task(f"{variation.key} {side}", changed, measure, compared))
                places[tasks[-1].key] = variation, side
        self._total = max(self._total, self._done + len(tasks))
        own = shared_by(Task("", scene, measure))
        tasks.sort(key=lambda task: shared_by(task) != own)  # first those that share the scene's solution
        for outcome in self._crew.solve(tasks):
            moved, side = places[outcome.key]
            moved.found[side] = outcome
            self._count(moved.key)

    def _count(self, text: str) -> None:
        self._done += 1
        self._report.step(self._done, self._total, text)


def _beside(scene: Scene, moved: _Moved) -> Scene:
    """The scene with a field moved by a small part of its step; the scene itself if that is not allowed."""
    try:
        return scene.replace({moved.key: moved.at + _BESIDE * moved.step})
    except SceneError:
        return scene


def _require_quantities(quantities: Sequence[Quantity], base: Outcome) -> None:
    problems = [
        Problem(
            "of", quantity.text, "a quantity that a result of this scene has", f"its result has no {quantity.text}"
        )
        for quantity in quantities
        if quantity.path not in base.measured.variables
    ]
    if problems:
        raise SceneError(problems, "sensitivities")


def _stretched(base: Outcome, stretch: float) -> Outcome:
    """The outcome of the same wear after `stretch` times the meshes."""
    known = base.measured.variables
    changed = {path: stretch * known[path] for path in INVERSE_TO_COEFFICIENT if path in known}
    return replace(base, measured=replace(base.measured, variables=known | changed))


def _settled(scene: Scene, measure: Measure, runs: _Runs) -> tuple[Scene, Outcome]:
    """The scene with the numerics of its run, and its outcome: other numerics would make quantities jump."""
    assert scene.wear is not None
    until = scene.wear.until
    scene = settled(scene)
    base = runs.one(scene, measure)
    known = base.measured.variables
    if scene.numerics.wear_steps == "auto" and until.meshes is not None and MESHES in known:
        scene = scene.replace({"numerics.wear_steps": int(known[MESHES].size) - 1})
    return scene, base


def _shared_with(scene: Scene, moved: Mapping[str, _Moved], quantities: Sequence[Quantity]) -> dict[str, str]:
    """The number of meshes, if it shares the runs of the wear coefficient: both change by the same fraction."""
    coefficient, meshes = moved.get(_COEFFICIENT), moved.get(_MESHES_RUN)
    if coefficient is None or meshes is None or any(quantity.variable.group != "history" for quantity in quantities):
        return {}
    rated = any(isinstance(table, RatingTable) for table in vars(scene.effects).values())
    alike = np.isclose(coefficient.step * meshes.at, meshes.step * coefficient.at, rtol=1e-9)
    return {} if rated or not alike else {_MESHES_RUN: _COEFFICIENT}


def _bends(moved: _Moved, quantity: Quantity, base: Outcome) -> bool:
    """Whether a first pair of values does not determine the derivative."""
    values = moved.values(quantity)
    if not all(np.isfinite(values.get(side, np.nan)) for side in _NEAR):
        return True
    middle = quantity.value(base.measured, low_is_good=True)
    change, bend = abs(values[1] - values[-1]), abs(_second_difference(values, middle))
    return 2.0 * bend > _STRAIGHT * change and _KINKED * bend > moved.slight * abs(middle)


def _bends_unevenly(moved: _Moved, quantity: Quantity, base: Outcome) -> bool:
    """Whether slopes that bend change by more from the second step to the third than from the first to the second."""
    if not _bends(moved, quantity, base):
        return False
    values, middle = moved.values(quantity), quantity.value(base.measured, low_is_good=True)
    if not all(np.isfinite(values.get(side, np.nan)) for side in (*_NEAR, _AHEAD)):
        return True
    third = _third_difference(values, middle, 1)
    return abs(third) > _EVEN_AHEAD * abs(_second_difference(values, middle))


def _second_difference(values: Mapping[int, float], middle: float) -> float:
    """Second difference over one step to either side."""
    return values[1] - 2.0 * middle + values[-1]


def _third_difference(values: Mapping[int, float], middle: float, sign: int) -> float:
    """Third difference of four values in a row, two of them on the side of the sign."""
    return values[2 * sign] - 3.0 * values[sign] + 3.0 * middle - values[-sign]


def _slopes(values: Mapping[int, float], middle: float, step: float) -> tuple[float, float, bool]:
    """Derivative, its error and whether there is a kink, from values at sides; NaN where there are too few."""
    known = {side: value for side, value in values.items() if np.isfinite(value)}
    if set(values) == set(known) == set(_NEAR):
        slope = (known[1] - known[-1]) / (2.0 * step)
        return slope, _KINKED * abs(_second_difference(known, middle)) / step, False
    if len(known) == len(_SIDES):
        near = (known[1] - known[-1]) / (2.0 * step)
        far = (known[2] - known[-2]) / (4.0 * step)
        slope, error = (4.0 * near - far) / 3.0, abs(near - far) / 3.0
        bend = abs(_second_difference(known, middle))
        uneven = max(abs(_third_difference(known, middle, sign)) for sign in (-1, 1))
        if uneven <= _EVEN * bend:
            return slope, error, False
        return slope, max(error, (_KINKED * bend + _BEYOND * uneven) / step), bend / step > _KINK * abs(slope)
    for sign in (1, -1):
        if set(known) == {-1, 1, 2 * sign}:
            rest = sign * _third_difference(known, middle, sign) / (6.0 * step)
            return (known[1] - known[-1]) / (2.0 * step) - rest, abs(rest), False
        if sign in known and 2 * sign in known:
            near = sign * (known[sign] - middle) / step
            far = sign * (known[2 * sign] - middle) / (2.0 * step)
            return 2.0 * near - far, abs(near - far), False
    return np.nan, np.nan, False


def _dataset(scene: Scene, quantities: Sequence[Quantity], moved: Sequence[_Moved], base: Outcome) -> xr.Dataset:
    shape = len(quantities), len(moved)
    slope, error, relative = np.full(shape, np.nan), np.full(shape, np.nan), np.full(shape, np.nan)
    kink = np.zeros(shape, bool)
    middle = np.array([quantity.value(base.measured, low_is_good=True) for quantity in quantities])
    for k, entry in enumerate(moved):
        for q, quantity in enumerate(quantities):
            slope[q, k], error[q, k], kink[q, k] = _slopes(entry.values(quantity), float(middle[q]), entry.step)
            if not entry.exact:
                left = _SCATTER * abs(float(middle[q])) / entry.step + _LEAST_ERROR * abs(slope[q, k])
                error[q, k] = np.maximum(error[q, k], left)
            relative[q, k] = slope[q, k] * entry.at / middle[q] if middle[q] else np.nan
    size = np.abs(middle)[:, None] * np.array([entry.slight / entry.step for entry in moved])
    negligible = (np.abs(slope) <= size) & (error <= size)
    doubtful = (kink | ~(error <= _DOUBTFUL * np.abs(slope))) & ~negligible
    missing = {"missing_because": "the scene cannot be solved on both sides of the field's value: see message"}
    both = ("quantity", "field")
    per_unit = "derivative, units of the quantity per unit of the field"
    data = {
        "derivative": (both, slope, {"long_name": per_unit, **missing}),
        "error": (both, error, {"long_name": "error of the derivative", **missing}),
        "relative": (both, relative, {"units": "1", "long_name": "relative change over relative change", **missing}),
        "kink": (both, kink, {"long_name": "slopes to either side differ"}),
        "doubtful": (both, doubtful, {"long_name": "a kink, or an error above 1 % of a derivative that matters"}),
        "value": ("quantity", middle, {"long_name": "value in the scene, in its unit"}),
        "units": ("quantity", np.array([quantity.units for quantity in quantities]), {}),
        "step": ("field", np.array([entry.step for entry in moved]), {"long_name": "step, in the unit of the field"}),
        "field_value": (
            "field",
            np.array([entry.at for entry in moved]),
            {"long_name": "value in the scene, in its unit"},
        ),
        "runs": ("field", np.array([entry.runs for entry in moved]), {"long_name": "scenes solved for the field"}),
        "message": (
            "field",
            np.array([entry.message for entry in moved], dtype=np.str_),
            {"long_name": "why a side has no value"},
        ),
    }
    coords = {"quantity": [quantity.text for quantity in quantities], "field": [entry.key for entry in moved]}
    attrs = {
        "title": f"Sensitivities of {scene.title or 'a scene'}",
        "source": f"semiwear {version()}",
        "scene_toml": scene.to_toml(),
        "scene_sha256": scene.sha256,
    }
    return xr.Dataset(data, coords=coords, attrs=attrs)
