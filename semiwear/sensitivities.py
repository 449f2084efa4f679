"""Sensitivities: by how much quantities of worn flanks change with the fields of a scene.

Each field is moved by one and by two steps to either side, everything else of the run being alike: its grids, its
number of wear steps, and the compliance and contact lines that it shares with the scene. Central differences d(h) and
d(2h) give the derivative (Richardson 1911, Phil. Trans. R. Soc. A 210, 307-357)

    d = [4 d(h) - d(2h)] / 3,    error |d(h) - d(2h)| / 3.

Slopes to either side differ by h f'' where a quantity is smooth: half as much over one step as over two. Where they
differ as much over both, the quantity has a kink, such as where a tip comes to press.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from semiwear.errors import Problem, SceneError, SemiwearError
from semiwear.optimise.quantity import Quantity, quantity_of
from semiwear.optimise.space import is_number, scene_value
from semiwear.results.provenance import version
from semiwear.scene import Scene
from semiwear.scene.values import shown
from semiwear.simulate import Progress
from semiwear.sweep.bar import hearing
from semiwear.sweep.measure import MESHES, Measure, Measured
from semiwear.sweep.outcome import Outcome, Status, solve
from semiwear.sweep.processes import in_processes
from semiwear.sweep.scenes import Task
from semiwear.sweep.variation import read_variation
from semiwear.threads import available_threads

__all__ = ["sensitivities"]

FloatArray = NDArray[np.float64]

_STEP = 0.01  # of a field's value
_SIDES = (-2, -1, 1, 2)
_MOST_FIELDS = 30
_KINK = 0.05  # of the derivative: by how much slopes to either side differ where one is told
_SMOOTH = 1.5  # times as much over two steps as over one: smooth, 2 where nothing else disturbs


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
        Default step: 1 % of the value.
    workers : int, optional
        Processes; 0: in this one. Default: one a core.
    progress : Progress or bool, optional
        Hears of every run; True shows a bar (extra ``progress``).

    Returns
    -------
    Dataset
        Along `quantity` and `field`: `derivative` in units of the quantity over that of the field, its `error`,
        `relative` (change of the quantity over that of the field, both relative), `kink` where slopes to either side
        differ; NaN, with its reason in `message` along `field`, where neither side can be solved.

    Raises
    ------
    SceneError
        With everything that is wrong with the arguments, before anything runs.
    SemiwearError
        The scene itself cannot be solved.

    Notes
    -----
    It takes four runs a field, and one more.

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
    names = [of] if isinstance(of, str) else list(of)
    quantities = [found for name in names if (found := quantity_of("of", name, problems)) is not None]
    if not names:
        problems.append(Problem("of", "nothing", "one quantity or more", 'such as "wear_depth_max"'))
    steps = _steps(scene, to, problems)
    if scene.wear is None:
        problems.append(Problem("wear", None, "a table [wear]", "loaded_contact is for scenes without wear"))
    if workers is not None and (isinstance(workers, bool) or not isinstance(workers, int) or workers < 0):
        problems.append(Problem("workers", shown(workers), "a whole number, 0 or more", "leave it out"))
    if problems:
        raise SceneError(problems, "sensitivities")
    measure = Measure(tuple(dict.fromkeys(quantity.path for quantity in quantities)))
    count = available_threads() if workers is None else workers
    with hearing(progress) as hears:
        total = 1 + len(_SIDES) * len(steps)
        base = solve(Task("", scene, measure))
        hears.step(1, total, "the scene")
        if base.status is not Status.DONE:
            raise SemiwearError(f"sensitivities: the scene itself cannot be solved: {base.message}")
        tasks, refused = _tasks(_paired(scene, base), steps, measure)
        outcomes: dict[str, Outcome] = {}
        solved = in_processes(tasks, count) if count and len(tasks) > 1 else map(solve, tasks)
        for done, outcome in enumerate(solved, 2):
            outcomes[outcome.key] = outcome
            hears.step(done, total, outcome.key.rpartition(" ")[0])
    return _dataset(scene, quantities, steps, base.measured, outcomes, refused)


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
    try:
        read_variation(scene, {key: [1.0]}, "grid")
    except SceneError as error:
        unknown = next((problem for problem in error.problems if "did you mean" in problem.fix), None)
        if unknown is not None:
            return unknown
    fix = "give the scene a value, or a step in a mapping where a field that is left out counts as 0"
    return Problem(key, shown(value), "a field that is a number", fix)


def _paired(scene: Scene, base: Outcome) -> Scene:
    """The scene with the number of wear steps that it took: another one would make quantities jump."""
    assert scene.wear is not None
    if scene.numerics.wear_steps != "auto" or scene.wear.until.meshes is None or scene.numerics.accuracy is not None:
        return scene
    if MESHES not in base.measured.variables:
        return scene
    return scene.replace({"numerics.wear_steps": int(base.measured.variables[MESHES].size) - 1})


def _tasks(scene: Scene, steps: Mapping[str, float], measure: Measure) -> tuple[list[Task], dict[str, str]]:
    """Runs to either side of every field, and why some are no legal scenes."""
    tasks, refused = [], {}
    for key, step in steps.items():
        value = float(scene_value(scene, key) or 0.0)
        for side in _SIDES:
            name = f"{key} {side}"
            try:
                changed = scene.replace({key: value + side * step})
            except SceneError as error:
                refused[name] = "; ".join(str(problem) for problem in error.problems)
                continue
            tasks.append(Task(name, replace(changed, title=scene.title), measure))
    return tasks, refused


def _slopes(values: Mapping[int, float], middle: float, step: float) -> tuple[float, float, bool]:
    """Derivative, its error and whether there is a kink, from values at sides; NaN where there are too few."""
    known = {side: value for side, value in values.items() if np.isfinite(value)}
    if len(known) == len(_SIDES):
        near = (known[1] - known[-1]) / (2.0 * step)
        far = (known[2] - known[-2]) / (4.0 * step)
        bends = [abs(known[s] - 2.0 * middle + known[-s]) / (s * step) for s in (1, 2)]  # of slopes to either side
        slope = (4.0 * near - far) / 3.0
        kink = bends[0] > _KINK * abs(slope) and bends[1] < _SMOOTH * bends[0]
        return slope, abs(near - far) / 3.0, kink
    for sign in (1, -1):
        if sign in known and 2 * sign in known:
            near = sign * (known[sign] - middle) / step
            far = sign * (known[2 * sign] - middle) / (2.0 * step)
            return 2.0 * near - far, abs(near - far), False
    return np.nan, np.nan, False


def _dataset(
    scene: Scene,
    quantities: Sequence[Quantity],
    steps: Mapping[str, float],
    base: Measured,
    outcomes: Mapping[str, Outcome],
    refused: Mapping[str, str],
) -> xr.Dataset:
    shape = len(quantities), len(steps)
    slope, error, relative = np.full(shape, np.nan), np.full(shape, np.nan), np.full(shape, np.nan)
    kink, middle = (
        np.zeros(shape, bool),
        np.array([quantity.value(base, low_is_good=True) for quantity in quantities]),
    )
    messages = []
    for k, (key, step) in enumerate(steps.items()):
        sides = {side: outcomes.get(f"{key} {side}") for side in _SIDES}
        reasons = [refused[name] for side in _SIDES if (name := f"{key} {side}") in refused]
        reasons += [one.message for one in sides.values() if one is not None and one.message]
        messages.append("; ".join(dict.fromkeys(reasons)))
        value = float(scene_value(scene, key) or 0.0)
        for q, quantity in enumerate(quantities):
            values = {
                side: np.nan if one is None else quantity.value(one.measured, low_is_good=True)
                for side, one in sides.items()
            }
            slope[q, k], error[q, k], kink[q, k] = _slopes(values, float(middle[q]), step)
            relative[q, k] = slope[q, k] * value / middle[q] if middle[q] else np.nan
    because = {"missing_because": "the scene cannot be solved on both sides of the field's value: see message"}
    both = ("quantity", "field")
    present = np.array([float(scene_value(scene, key) or 0.0) for key in steps])
    per_unit = "derivative, units of the quantity per unit of the field"
    data = {
        "derivative": (
            both,
            slope,
            {"long_name": per_unit, **because},
        ),
        "error": (both, error, {"long_name": "error of the derivative", **because}),
        "relative": (both, relative, {"units": "1", "long_name": "relative change over relative change", **because}),
        "kink": (both, kink, {"long_name": "slopes to either side differ"}),
        "value": ("quantity", middle, {"long_name": "value in the scene, in its unit"}),
        "units": ("quantity", np.array([quantity.units for quantity in quantities]), {}),
        "step": ("field", np.array(list(steps.values())), {"long_name": "step, in the unit of the field"}),
        "field_value": ("field", present, {"long_name": "value in the scene, in its unit"}),
        "message": ("field", np.array(messages, dtype=np.str_), {"long_name": "why a side has no value"}),
    }
    coords = {"quantity": [quantity.text for quantity in quantities], "field": list(steps)}
    attrs = {
        "title": f"Sensitivities of {scene.title or 'a scene'}",
        "source": f"semiwear {version()}",
        "scene_toml": scene.to_toml(),
        "scene_sha256": scene.sha256,
    }
    return xr.Dataset(data, coords=coords, attrs=attrs)
