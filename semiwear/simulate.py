"""The pipeline: a scene in, a labelled result out."""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import xarray as xr

from semiwear import collect
from semiwear.compile_ahead import compile_ahead
from semiwear.compliance.blas_threads import one_blas_thread
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.contact.loads import SlicePressures
from semiwear.error_peaks import error_amplitude
from semiwear.errors import ConvergenceError, EndlessWearError, Problem, SceneError
from semiwear.life import hours_per_mesh, life_group
from semiwear.plan import Compared, Plan, plan
from semiwear.plan.choices import kernels_of
from semiwear.results import build_tree, provenance
from semiwear.results.checkpoint import Keeper, KeptStep, NoCheckpoint, open_checkpoint
from semiwear.results.datasets import with_rating_errors
from semiwear.results.kinds import Errors, step_errors
from semiwear.results.run_identity import run_identity
from semiwear.scene import Scene
from semiwear.threads import in_threads, using_threads
from semiwear.wear.adaptive import AdaptiveStepper
from semiwear.wear.kept_state import restored_state, state_arrays
from semiwear.wear.parted_step import parted_step_to_depth
from semiwear.wear.step_count import depth_of_step, steps_for_depth
from semiwear.wear.stepping import WearState, WearStepper
from semiwear.wear.swept_line import Sweep, fresh_sweep
from semiwear.wear.two_stage import TwoStageStepper
from semiwear.wear.worn import Worn

_LOG = logging.getLogger(__name__)

ADAPTIVE_STATES = 8  # wear states of a run to a number of meshes whose steps follow an accuracy
_WEARING = "contact and wear"  # the stage


class Progress(Protocol):
    """Receiver of every finished wear step."""

    def step(self, done: int, total: int, text: str) -> None:
        """`done` of `total` steps are finished; `text` states the present wear."""


class NoProgress:
    """A receiver that does nothing."""

    def step(self, done: int, total: int, text: str) -> None:
        """Do nothing."""


@one_blas_thread()
def simulate(
    scene: Scene,
    *,
    progress: Progress | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    resume: bool = False,
    compared: Compared | None = None,
    last: bool = False,
    groups: Collection[str] | None = None,
    peaks: Collection[int] | None = None,
) -> xr.DataTree:
    """Wear the flanks of a scene with its own numerics, whatever accuracy it requests.

    Arguments, result and errors are those of `semiwear.simulate`; `compared` is that of `Plan`. With `last` the
    result holds the last wear state only, unless failure modes are rated, which needs them all. With `groups` it
    holds only these, `history` and ratings. With `peaks`, the peaks of the transmission error that
    ``numerics.peak_positions`` asks for are found in these wear states alone (-1 for the last); its amplitude in
    the others is that of the roll positions.
    """
    require_run(scene, checkpoint, resume)
    kept: Keeper = NoCheckpoint()
    if checkpoint is not None:
        kept = open_checkpoint(checkpoint, run_identity(scene.to_toml()), resume=resume)
    compile_ahead(kernels_of(scene), scene.numerics.threads)
    with kept, using_threads(scene.numerics.threads):
        physics = replace(plan(scene), compared=compared)
        return _simulated(physics, kept, progress or NoProgress(), last, groups, peaks)


def require_run(scene: Scene, checkpoint: str | os.PathLike[str] | None, resume: bool) -> None:
    """Raise `SceneError` if a scene has no wear, or a run is to be resumed without a checkpoint."""
    problems = wear_problems(scene)
    if resume and checkpoint is None:
        fix = "give checkpoint=FOLDER as well"
        problems.append(Problem("resume", resume, "True together with a checkpoint", fix))
    if problems:
        raise SceneError(problems)


def wear_problems(scene: Scene) -> list[Problem]:
    """The problem of a scene without wear, if it is one."""
    fix = "add coefficient_mm2_per_N and an end in [wear.until], or take sw.loaded_contact for the unworn teeth"
    return [Problem("wear", None, "a table [wear]", fix)] if scene.wear is None else []


def _simulated(
    physics: Plan,
    kept: Keeper,
    progress: Progress,
    last: bool,
    only: Collection[str] | None,
    peaks: Collection[int] | None,
) -> xr.DataTree:
    clock = _Clock()
    teeth = physics.loaded_teeth()
    clock.lap("geometry and compliance")
    stepper = physics.wear_stepper(teeth)
    states = _restored(physics, stepper, kept, clock)
    stopped = None
    life: collect.Arrays = {}
    try:
        for step in _wear_steps(physics, teeth, physics.wear_steps(stepper), states, kept):
            states.append(step.state)
            seconds = {_WEARING: clock.since(_WEARING)} | physics.clock.seconds
            kept.add(KeptStep(step.total, seconds, state_arrays(step.state)))
            if step.done:
                progress.step(step.done, step.total, step.text)
                _LOG.info("wear step %d of %d: %s", step.done, step.total, step.text)
        life = life_group(physics, stepper, progress.step)
    except ConvergenceError as error:
        if not states:
            raise
        stopped = error
    clock.lap(_WEARING)
    first = len(states) - 1 if last and not physics.rates else 0
    with_peaks = range(len(states)) if peaks is None else [range(len(states))[k] for k in peaks]
    tree = _result(physics, teeth, stepper, states, clock, life, first, only, with_peaks)
    if stopped is not None:
        message = f"{stopped} ({_kept_of(len(states) - 1)})"
        if isinstance(stopped, EndlessWearError):
            raise EndlessWearError(message, tree, life=stopped.life) from stopped
        raise ConvergenceError(message, tree) from stopped
    return tree


def _kept_of(steps: int) -> str:
    """Message on the part of a stopped run that is kept."""
    if not steps:
        return "no wear step was finished; the error's `result` holds the unworn contact"
    finished = f"{steps} wear steps were finished" if steps > 1 else "1 wear step was finished"
    return f"{finished}; the error's `result` holds {'them' if steps > 1 else 'it'}"


@dataclass(frozen=True)
class _WearStep:
    """A finished wear step: number `done` of `total`; 0 is the unworn state, with an unknown total."""

    state: WearState
    done: int = 0
    total: int = 0
    text: str = ""


def _restored(physics: Plan, stepper: WearStepper, kept: Keeper, clock: _Clock) -> list[WearState]:
    """The wear states of a checkpoint; solvers and clocks are restored to those after the last."""
    if not kept.steps:
        return []
    last = kept.steps[-1]
    clock.earlier = {_WEARING: last.seconds[_WEARING]}
    physics.clock.seconds |= {name: spent for name, spent in last.seconds.items() if name != _WEARING}
    return [restored_state(stepper, step.arrays) for step in kept.steps]


def _wear_steps(
    physics: Plan,
    teeth: LoadedTeeth,
    stepper: WearStepper | TwoStageStepper | AdaptiveStepper,
    known: Sequence[WearState],
    kept: Keeper,
) -> Iterator[_WearStep]:
    """The unworn state and one after each wear step, without those that are known."""
    wear = physics.scene.wear
    assert wear is not None
    done = max(len(known) - 1, 0)
    state = known[-1] if known else stepper.start()
    if not known:
        yield _WearStep(state)
    if wear.until.control_depths_um is not None:
        point = physics.control_point(teeth)
        assert point is not None
        depths = wear.until.control_depths_um
        states, part = list(known) or [state], physics.depth_of_part(teeth)
        there = [0.0, *(1e-3 * depth for depth in depths)]  # at the control point, in every state
        for k, depth in enumerate(depths[done:], done + 1):
            if part is None:
                state = stepper.step_to_depth(states[-1], point, there[k])
            else:
                state = parted_step_to_depth(stepper, states, point, there, part, smooth=teeth.smooth)
            states.append(state)
            yield _WearStep(state, k, len(depths), f"{depth:g} um at the control point")
        return
    assert wear.until.meshes is not None
    steps = physics.scene.numerics.wear_steps
    count = int(steps) if steps != "auto" else kept.steps[-1].total if done else 0
    if not count:
        count = _state_count(stepper, state, wear.until.meshes, teeth.pair.base_pitch)
    for k in range(done + 1, count + 1):
        state = stepper.step(state, wear.until.meshes / count)
        yield _WearStep(state, k, count, f"{state.meshes:.3g} meshes, {_depths_text(state)} at most")


def _state_count(
    stepper: WearStepper | TwoStageStepper | AdaptiveStepper, start: WearState, meshes: float, base_pitch: float
) -> int:
    """Number of wear states of a run, from the expected depth on either body, unless steps follow an accuracy."""
    if isinstance(stepper, AdaptiveStepper):
        return ADAPTIVE_STATES
    return steps_for_depth(stepper.predicted_depth(start, meshes), base_pitch)


def _depths_text(state: WearState) -> str:
    """The greatest wear depth of every body that wears."""
    depths = state.deepest
    texts = [f"{1e3 * depth:.3g} um" for depth in depths.values()]
    if len(texts) > 1:
        texts = [f"{body} {depth}" for body, depth in zip(depths, texts, strict=True)]
    return ", ".join(texts) or "0 um"


def _result(
    physics: Plan,
    teeth: LoadedTeeth,
    stepper: WearStepper,
    states: list[WearState],
    clock: _Clock,
    life: collect.Arrays,
    first: int,
    only: Collection[str] | None,
    with_peaks: Collection[int],
) -> xr.DataTree:
    """Result of the wear states from `first` on, in some groups or in all."""
    reported_states = states[first:]
    contacts = [state.contact for state in reported_states]
    fresh = fresh_sweep(teeth.pair, teeth.lines)
    pressures = in_threads(teeth.pressures, contacts)
    parts = _parts(physics, stepper, reported_states, pressures, fresh, [k - first for k in with_peaks])
    groups = {name: collect.stacked([part[name] for part in parts]) for name in parts[0]}
    if only is None or "flank" in only:
        groups["flank"] = collect.flank(teeth, fresh) | {"wear_depth": collect.wear_maps(teeth, contacts)}
        groups["flank"] |= collect.contact_patterns(teeth, contacts)
    groups["engagement"] |= collect.slices(teeth)
    if life:
        groups["life"] = life
    known = [(own, part["engagement"].get("root_stress")) for own, part in zip(pressures, parts, strict=True)]
    rated = physics.ratings(stepper, states, hours_per_mesh(physics.scene, teeth.pair), known)
    if rated is not None:
        groups["ratings"] = rated.arrays
    clock.lap("stress and results")
    groups["diagnostics"] |= {"seconds": np.array(list(clock.seconds.values()))}
    quantities = groups["history"] if rated is None else groups["history"] | rated.quantities
    groups["diagnostics"] |= _intended_step(physics, teeth)
    estimates = _step_errors(physics, reported_states, quantities)
    if estimates:
        groups["diagnostics"]["error_estimate"] = np.array(list(estimates.values()))
    spent = physics.clock.seconds
    if spent:
        groups["diagnostics"] |= {"effect_seconds": np.array(list(spent.values()))}
    coords = collect.coordinates(teeth) | {
        "wear_step": np.arange(first, len(states)),
        "meshes": np.array([state.meshes for state in reported_states]),
        "stage": np.array(list(clock.seconds)),
    }
    if spent:
        coords["effect"] = np.array(list(spent))
    if estimates:
        coords["quantity"] = np.array(list(estimates))
    names = set(groups) if only is None else {"history", "ratings", *only}
    needed = names if rated is None else names | {"diagnostics"}  # ratings take their errors from there
    groups = {name: arrays for name, arrays in groups.items() if name in needed}
    if rated is None:
        return build_tree(groups, coords, attributes(physics, "simulate"))
    coords["mode"] = np.array(rated.modes)
    tree = with_rating_errors(build_tree(groups, coords, attributes(physics, "simulate"), {"ratings": rated.factors}))
    return tree.drop_nodes(needed - names)


def _parts(
    physics: Plan,
    stepper: WearStepper,
    states: Sequence[WearState],
    pressures: Sequence[SlicePressures],
    fresh: Sweep,
    with_peaks: Collection[int],
) -> list[dict[str, collect.Arrays]]:
    """Arrays of every wear state by itself, group by group."""
    teeth, point = stepper.teeth, physics.control_point(stepper.teeth)
    poissons_ratio = physics.scene.material.gear.poissons_ratio
    observers = physics.observers(teeth)

    def own(index: int) -> dict[str, collect.Arrays]:
        state, pressure = states[index], pressures[index]
        contact = state.contact
        part = {
            "engagement": collect.engagement(teeth, contact, pressure, fresh),
            "mesh_cycle": collect.mesh_cycle(teeth, contact),
        }
        part["history"] = collect.history(teeth, contact, pressure, part)
        part["history"] |= collect.volumes(teeth, state)
        part["history"] |= collect.subsurface(teeth, contact, pressure, poissons_ratio)
        return part

    parts = in_threads(own, range(len(states)))
    for k, (part, state, pressure) in enumerate(zip(parts, states, pressures, strict=True)):
        contact = state.contact
        engagement, once = collect.observed(teeth, contact, pressure, observers, physics.clock)
        part["engagement"] |= engagement
        part["history"] |= once
        if physics.scene.numerics.peak_positions is not None and k in with_peaks:
            part["history"]["transmission_error_amplitude"] = np.asarray(
                error_amplitude(physics, stepper.teeth, contact)
            )
        if point is not None:
            watched = stepper.depth_at(point, point.wear(Worn(contact.wear, contact.driving_wear)))
            part["history"]["wear_depth_control_point"] = np.asarray(1e3 * watched)
        part["diagnostics"] = collect.residuals(contact)
        if stepper.factor is not None:
            part["diagnostics"]["wear_law_residual"] = np.asarray(state.law_residual)
        if stepper.depth_factor is None:
            part["diagnostics"] |= collect.volume_residual(teeth, state)
    return parts


def _intended_step(physics: Plan, teeth: LoadedTeeth) -> collect.Arrays:
    """Intended depth of a wear step, unless steps follow an accuracy."""
    if "wear_steps" in physics.scene.numerics.chosen_for_accuracy:
        return {}
    return {"usual_step_depth": np.asarray(1e3 * depth_of_step(teeth.pair.base_pitch))}


def _step_errors(physics: Plan, states: Sequence[WearState], history: collect.Arrays) -> Errors:
    """Error of every reported quantity by the wear steps, if an accuracy is requested."""
    if physics.scene.numerics.accuracy is None:
        return {}
    meshes = np.array([state.meshes for state in states])
    return step_errors(max(state.error for state in states), history | {"meshes": meshes})


def attributes(physics: Plan, action: str) -> dict[str, str]:
    """Root attributes of a result."""
    scene = physics.scene
    return provenance(
        title=scene.title or "semiwear result",
        scene_toml=scene.to_toml(),
        physics=str(physics),
        fidelity=scene.numerics.fidelity,
        references="\n".join(physics.references),
        action=action,
        input_files=physics.input_files,
    )


class _Clock:
    """Seconds of each stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.earlier: dict[str, float] = {}  # time of the stage before the run was resumed
        self._last = time.perf_counter()

    def since(self, stage: str) -> float:
        """Seconds of the present stage so far."""
        return time.perf_counter() - self._last + self.earlier.get(stage, 0.0)

    def lap(self, stage: str) -> None:
        self.seconds[stage] = self.since(stage)
        self._last = time.perf_counter()
