"""Screening: effects that matter in a scene, and their cost.

One mesh cycle of the unworn teeth is run with the scene as it is, then with each absent effect added at its
documented default, and with each present one removed. The scene is not changed.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import partial
from html import escape
from typing import TypeVar

import numpy as np
import xarray as xr

from semiwear import collect
from semiwear.compile_ahead import compile_ahead
from semiwear.compliance.blas_threads import one_blas_thread
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.errors import ConvergenceError, Problem, SceneError, SemiwearError
from semiwear.html_text import html_table
from semiwear.meshing.flank_pair import BODIES
from semiwear.plain_text import folded, table
from semiwear.plan import plan
from semiwear.plan.choices import kernels_of
from semiwear.plan.effects import hardness_laws
from semiwear.results import VARIABLES
from semiwear.scene import EFFECTS, Scene
from semiwear.scene.mechanical_effects import RunLife
from semiwear.scene.rating_tables import RatingTable
from semiwear.scene.schema import schema_of_scene
from semiwear.screen_ratings import FAILS, NEAR, nearness, step_to_end
from semiwear.simulate import NoProgress, Progress
from semiwear.threads import using_threads
from semiwear.untyped import Table
from semiwear.wear.step_count import steps_of_life
from semiwear.wear.worn import Worn

_T = TypeVar("_T")

QUANTITIES = (
    "wear rate",
    "pressure",
    "root stress pinion",
    "root stress gear",
    "transmission error mean",
    "transmission error amplitude",
)
"""Compared quantities, in the order of the table."""

_SPEED = "operation.pinion_speed_rpm"
_HARDNESS, _LIFE = "wear_law.hardness", "run_life"
_UNRATED = "not run: gives a safety and changes nothing; its table needs data of the materials"
_RUNS = 2  # before and after the effects; other processes only add to the time
_HEAD = ("effect", "on", "wear", "pressure", "root p", "root g", "TE mean", "TE ampl", "time", "verdict")


@dataclass(frozen=True)
class ScreenedEffect:
    """Change of one mesh cycle by an effect.

    Attributes
    ----------
    effect : str
        Named as in `EFFECTS`.
    present : bool
        Whether the scene has it, so that it was removed; otherwise it was added.
    changes : mapping
        Relative change of each of `QUANTITIES` that exists; empty if the effect was not run.
    time : float or None
        Processor time over that of the scene as it is.
    note : str
        Other effects added or removed with it, its own quantities, or the reason why it was not run.
    """

    effect: str
    present: bool
    changes: Mapping[str, float]
    time: float | None
    note: str = ""

    @property
    def greatest(self) -> float:
        """Greatest relative change, without its sign; 0 if the effect was not run."""
        return max((abs(change) for change in self.changes.values()), default=0.0)


@dataclass(frozen=True)
class Screening:
    """Effects that matter in a scene, printed as a table.

    Attributes
    ----------
    scene : Scene
    threshold : float
        Relative change from which an effect counts.
    base : mapping
        `QUANTITIES` of the scene itself: wear rate [um a mesh], MPa and arcsec.
    seconds : float
        Processor time of its mesh cycle, teeth included.
    rows : tuple of ScreenedEffect
        Every effect.
    """

    scene: Scene
    threshold: float
    base: Mapping[str, float]
    seconds: float
    rows: tuple[ScreenedEffect, ...]

    @property
    def called_for(self) -> tuple[str, ...]:
        """Absent effects that change something by the threshold or more, the greatest change first."""
        absent = [row for row in self.rows if not row.present and row.greatest >= self.threshold]
        return tuple(row.effect for row in sorted(absent, key=lambda row: -row.greatest))

    @property
    def could_go(self) -> tuple[str, ...]:
        """Present effects that were removed and changed less than the threshold."""
        return tuple(row.effect for row in self.rows if row.present and row.changes and not self._counts(row))

    @property
    def near_limits(self) -> tuple[str, ...]:
        """Failure modes of the scene whose safety falls below or near the required one within the run."""
        return tuple(row.effect for row in self.rows if _rates(row.effect) and row.note.startswith((FAILS, NEAR)))

    def to_dataset(self) -> xr.Dataset:
        """`change` over effect and quantity, `time_ratio` and `present` over effect; NaN for effects not run."""
        change = [[row.changes.get(name, np.nan) for name in QUANTITIES] for row in self.rows]
        return xr.Dataset(
            {
                "change": (("effect", "quantity"), np.array(change)),
                "time_ratio": ("effect", np.array([np.nan if r.time is None else r.time for r in self.rows])),
                "present": ("effect", np.array([row.present for row in self.rows])),
            },
            {"effect": [row.effect for row in self.rows], "quantity": list(QUANTITIES)},
        )

    def __str__(self) -> str:
        called, limit = ", ".join(self.called_for) or "none", f"{100.0 * self.threshold:g} %"
        parts = [
            folded(f"as it is: {self._as_it_is()}"),
            folded(
                "change of one unworn mesh cycle in % when an absent effect is added at its default or a present one "
                "removed; time: processor time, once as it is:"
            ),
            table(_HEAD, [self._cells(row) for row in self.rows]),
            folded(f"called for at {limit}: {called}"),
        ]
        if self.could_go:
            parts.append(folded(f"present, yet below {limit}: {', '.join(self.could_go)}"))
        if any(row.present and _rates(row.effect) for row in self.rows):
            parts.append(folded(f"failure modes that fail or come near it: {', '.join(self.near_limits) or 'none'}"))
        return "\n\n".join(parts)

    def _repr_html_(self) -> str:
        caption = f"as it is: {self._as_it_is()}; change in % when an effect is added or removed"
        called = ", ".join(self.called_for) or "none"
        summary = f"<p>called for at {100.0 * self.threshold:g} %: <b>{escape(called)}</b></p>"
        return summary + html_table(_HEAD, [self._cells(row) for row in self.rows], caption)

    def _counts(self, row: ScreenedEffect) -> bool:
        return row.greatest >= self.threshold

    def _cells(self, row: ScreenedEffect) -> tuple[str, ...]:
        changes = [_percent(row.changes[name]) if name in row.changes else "-" for name in QUANTITIES]
        cells = [*changes, "-" if row.time is None else f"x{row.time:.2f}"]
        cells = [cell.rjust(len(head)) for cell, head in zip(cells, _HEAD[2:-1], strict=True)]
        return (row.effect, "yes" if row.present else "no", *cells, f"{self._verdict(row)}{row.note}")

    def _verdict(self, row: ScreenedEffect) -> str:
        if not row.changes:
            return ""
        words = ("matters", "could go") if row.present else ("called for", "no")
        return words[0 if self._counts(row) else 1] + ("; " if row.note else "")

    def _as_it_is(self) -> str:
        base = self.base
        parts = [f"greatest pressure {base['pressure']:.0f} MPa"]
        if "wear rate" in base:
            parts.insert(0, f"greatest wear {1e6 * base['wear rate']:.3g} um in a million meshes")
        if "root stress gear" in base:
            parts.append(f"root stress {base['root stress pinion']:.0f} and {base['root stress gear']:.0f} MPa")
        error = base["transmission error mean"], base["transmission error amplitude"]
        parts.append("transmission error {:.2f} arcsec, amplitude {:.2f}".format(*error))
        return f"{'; '.join(parts)} ({self.seconds:.1f} s)"


@dataclass(frozen=True)
class _Cycle:
    """One mesh cycle: `QUANTITIES`, those of observers, processor time [s], the teeth, one mesh's wear by body."""

    values: dict[str, float]
    observed: dict[str, str]
    seconds: float
    teeth: LoadedTeeth
    wear: dict[str, np.ndarray]


class _NotRun(Exception):
    """Reason why an effect is not run."""


@one_blas_thread()
def screen(
    scene: Scene, threshold: float = 0.02, *, speed_rpm: float = 1000.0, progress: Progress | None = None
) -> Screening:
    """Effects that matter in a scene, and their cost.

    Effects that act through wear depth are judged at the end of the run; those that only report change nothing.
    The greatest wear of unworn teeth may lie where a tip edge is in contact, which runs in first.

    Parameters
    ----------
    scene : Scene
    threshold : float
        An absent effect is called for where it changes the greatest wear rate, pressure (away from edges), root
        stress, or mean or amplitude of the transmission error by this fraction or more. Default 0.02.
    speed_rpm : float
        Pinion speed for effects that need one if the scene gives none. Default 1000.
    progress : Progress, optional
        Called after every effect.

    Raises
    ------
    SceneError
        With all faults: `threshold` or `speed_rpm` is not a finite number above 0.
    ConvergenceError
        If the scene itself cannot be solved; an effect that cannot is listed with the reason.

    Examples
    --------
    >>> import semiwear as sw
    >>> coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8, "wear": None}
    >>> found = sw.screen(sw.load_scene("spur_fzg_c").replace(coarse))
    >>> "called for at 2 %" in str(found)
    True
    """
    problems: list[Problem] = []
    if not 0.0 < threshold < np.inf:
        problems.append(Problem("threshold", threshold, "a fraction above 0", "0.02 for 2 %"))
    _, slow = schema_of_scene(scene).rules[_SPEED].apply("speed_rpm", speed_rpm)
    if slow is not None:
        problems.append(slow)
    if problems:
        raise SceneError(problems, "screen")
    compile_ahead(kernels_of(scene, wears=True), scene.numerics.threads)
    with using_threads(scene.numerics.threads):
        return _screening(scene, threshold, speed_rpm, progress or NoProgress())


def _screening(scene: Scene, threshold: float, speed_rpm: float, progress: Progress) -> Screening:
    total, base = len(EFFECTS) + 1, _mesh_cycle(scene)
    before = _least_seconds(scene)
    progress.step(1, total, "the scene as it is")
    rows = []
    for k, name in enumerate(EFFECTS):
        rows.append(_screened(scene, name, base, speed_rpm))
        progress.step(k + 2, total, name)
    seconds = min(before, _least_seconds(scene))
    ratios = [replace(row, time=None if row.time is None else row.time / seconds) for row in rows]
    return Screening(scene, threshold, base.values, seconds, tuple(ratios))


def _least_seconds(scene: Scene) -> float:
    return min(_mesh_cycle(scene).seconds for _ in range(_RUNS))


def _cost_of_life(scene: Scene) -> str:
    """Cost of a life, in wear steps."""
    limit = 1e-3 * (scene.effects.run_life or RunLife()).depth_limit_um
    steps = steps_of_life(limit, plan(scene).flank_pair().base_pitch)
    return f"gives a life and changes nothing; takes about {steps} wear steps in two stages"


def _screened(scene: Scene, name: str, base: _Cycle, speed_rpm: float) -> ScreenedEffect:
    """The row of an effect; its time in seconds."""
    present = scene.effects.get(name) is not None
    if _rates(name):
        return ScreenedEffect(name, present, {}, None, nearness(scene, name) if present else _UNRATED)
    if name == _LIFE:
        note = _cost_of_life(scene) if scene.wear is not None else "not run: needs [wear]"
        return ScreenedEffect(name, present, {}, None, note)
    try:
        changes, notes = _without(scene, name) if present else _with(scene, name, speed_rpm)
        other = scene.replace(changes)
        cycle = _mesh_cycle(other)
        seconds = min(cycle.seconds, _mesh_cycle(other).seconds)  # the first may compile
    except (_NotRun, SemiwearError) as error:
        reasons = error.problems if isinstance(error, SceneError) else [error]
        return ScreenedEffect(name, present, {}, None, f"not run: {'; '.join(map(str, reasons))}")
    change = {key: _relative(value, base.values[key]) for key, value in cycle.values.items() if key in base.values}
    if name == _HARDNESS:
        try:
            factor, note = _hardness_at_the_end(*((scene, base) if present else (other, cycle)))
        except ConvergenceError as error:
            factor, note = 1.0, f"not judged at the end of the run: {error}"
        later = (1.0 / factor if present else factor) - 1.0
        change["wear rate"] = max(change["wear rate"], later, key=abs)
        notes.append(note)
    observed = cycle.observed.get(name) or base.observed.get(name)
    if observed:
        notes.append(f"{observed}{' now' if present else ''}")
    return ScreenedEffect(name, present, change, seconds, "; ".join(notes))


def _rates(name: str) -> bool:
    """Whether an effect is a failure mode."""
    return issubclass(EFFECTS[name], RatingTable)


def _percent(change: float) -> str:
    return "0" if change == 0.0 else f"{100.0 * change:+.1f}"


def _relative(value: float, before: float) -> float:
    if value == before:
        return 0.0
    return value / before - 1.0 if before != 0.0 else float(np.inf)


def _with(scene: Scene, name: str, speed_rpm: float) -> tuple[Table, list[str]]:
    """Changes that add an effect and those that it needs, and notes on them."""
    changes: Table = {}
    notes: list[str] = []
    pending = [name]
    while pending:
        effect = pending.pop()
        own = EFFECTS[effect].screening_table(scene)
        changes[f"effects.{effect}"] = own
        if effect != name:
            notes.append(f"with {effect}")
        values = {field.name: field.default for field in fields(EFFECTS[effect])} | own  # type: ignore[arg-type]
        for need in EFFECTS[effect].needed_with(values.__getitem__):
            if need == "wear" and scene.wear is None:
                raise _NotRun("needs [wear]")
            if need == _SPEED and scene.operation.pinion_speed_rpm is None and need not in changes:
                changes[need] = speed_rpm
                notes.append(f"at {speed_rpm:g} rpm")
            other = need.removeprefix("effects.")
            if other in EFFECTS and scene.effects.get(other) is None and need not in changes:
                pending.append(other)
    return changes, notes


def _without(scene: Scene, name: str) -> tuple[Table, list[str]]:
    """Changes that remove an effect and those that need it, and notes on them."""
    without = [name]
    for effect in without:
        for other, own in scene.effects.present():
            if f"effects.{effect}" in own.needed_with(partial(getattr, own)) and other not in without:
                without.append(other)
    notes = [f"together with {effect}, which needs it" for effect in without[1:]]
    return {f"effects.{effect}": None for effect in without}, notes


def _hardness_at_the_end(scene: Scene, cycle: _Cycle) -> tuple[float, str]:
    """Factor of the hardness law on the wear rate at the depth where the run ends, and a note on it.

    Of the two bodies, that with the greater effect of the law counts.
    """
    law, wear = scene.effects.wear_law.hardness, scene.wear
    assert law is not None and wear is not None
    found = hardness_laws(scene, cycle.teeth)
    assert found is not None
    begins = law.case_depth_um - 0.5 * law.transition_um
    factors_of_bodies: list[tuple[float, str]] = []
    for body, depth in _depths_at_the_end(scene, cycle.teeth).items():
        rates = cycle.wear[body]
        factors = np.broadcast_to(found[BODIES.index(body)].factor(np.asarray(1e-3 * depth)), rates.shape)
        factor = float(factors.flat[int(np.argmax(rates))])
        if depth <= begins:
            note = f"acts only beyond {begins:g} um, the {body} ends at {depth:.3g} um"
        else:
            note = f"wear rate at {depth:.3g} um, where the {body} ends; nothing before {begins:g} um"
        factors_of_bodies.append((factor, note))
    return max(factors_of_bodies, key=lambda body: abs(body[0] - 1.0))


def _depths_at_the_end(scene: Scene, teeth: LoadedTeeth) -> dict[str, float]:
    """Greatest depth of each worn body at the end of the run [um]: as prescribed, else by one implicit step."""
    wear = scene.wear
    assert wear is not None
    depths = wear.until.control_depths_um
    if depths is not None and wear.worn_bodies == (wear.watched_body,):
        return {wear.watched_body: depths[-1]}
    _, _, end = step_to_end(plan(scene), teeth)
    return {body: 1e3 * depth for body, depth in _by_body(end.worn, lambda wear: float(wear.max())).items()}


def _by_body(worn: Worn, value: Callable[[np.ndarray], _T]) -> dict[str, _T]:
    """Value of the wear of every body that wears."""
    both = dict(zip(BODIES, (worn.driving, worn.driven), strict=True))
    return {body: value(depth) for body, depth in both.items() if depth is not None and np.any(depth)}


def _mesh_cycle(scene: Scene) -> _Cycle:
    begin = time.process_time()
    physics = plan(scene)
    teeth = physics.loaded_teeth()
    values: dict[str, float] = {}
    wear: dict[str, np.ndarray] = {}
    if scene.wear is None:
        contact = teeth.load(np.zeros(teeth.grid.profile.shape))
    else:
        stepper = replace(physics.wear_stepper(teeth), implicit=False)
        start = stepper.start()
        contact, worn = start.contact, stepper.step(start, 1.0).worn
        wear = _by_body(worn, lambda depth: depth)
        values["wear rate"] = 1e3 * max(float(depth.max()) for depth in worn if depth is not None)
    pressure = teeth.pressures(contact)
    values["pressure"] = float(pressure.inner.max())
    if teeth.problem.bodies:
        for name, stress in zip(BODIES, teeth.root_stress(contact).max(axis=0), strict=True):
            values[f"root stress {name}"] = float(stress)
    error = collect.mesh_cycle(teeth, contact)["transmission_error_loaded"]
    values |= {"transmission error mean": float(error.mean()), "transmission error amplitude": float(np.ptp(error))}
    observed: dict[str, str] = {}
    for observer in physics.observers(teeth):
        found = observer.history(teeth, observer.engagement(teeth, contact, pressure))
        observed[observer.effect] = ", ".join(_in_words(name, value) for name, value in found.items())
    return _Cycle(values, observed, time.process_time() - begin, teeth, wear)


def _in_words(name: str, value: np.ndarray) -> str:
    units = VARIABLES["history", name].units
    return f"{name} {float(value):.4g} {units if units != '1' else ''}".rstrip()
