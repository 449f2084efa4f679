"""The pipeline: a scene in, a labelled result out."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Protocol

import numpy as np
import xarray as xr

from semiwear import collect
from semiwear.compliance.blas_threads import one_blas_thread
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.errors import ConvergenceError, SceneError
from semiwear.plan import Plan, plan
from semiwear.results import build_tree, provenance
from semiwear.scene import Scene
from semiwear.wear.stepping import WearState, WearStepper
from semiwear.wear.swept_line import fresh_sweep

__all__ = ["NoProgress", "Progress", "simulate"]

_DEPTH_A_STEP = 6e-3  # mm of greatest wear that an automatic wear step leaves, about
_AUTO_STEPS = (3, 40)


class Progress(Protocol):
    """Hears of every finished wear step."""

    def step(self, done: int, total: int, text: str) -> None:
        """`done` of `total` steps are finished; `text` says where the wear stands."""


class NoProgress:
    """Hears nothing."""

    def step(self, done: int, total: int, text: str) -> None:
        """Do nothing."""


@one_blas_thread()
def simulate(scene: Scene, *, progress: Progress | None = None, fidelity: str | None = None) -> xr.DataTree:
    """Wear the flank of a scene and follow what it does to contact, root stress and transmission error.

    Parameters
    ----------
    scene : Scene
        With a table [wear].
    progress : Progress, optional
        Hears of every finished wear step.
    fidelity : str, optional
        Instead of ``numerics.fidelity``.

    Returns
    -------
    DataTree
        Groups `/flank`, `/engagement`, `/mesh_cycle`, `/history`, `/diagnostics` (`semiwear.results.schema`);
        `wear_step` 0 is unworn.

    Raises
    ------
    SceneError
        If the scene has no wear, or `fidelity` is unknown.
    ConvergenceError
        If a load or wear step cannot be solved; it names the place and what to change, and its `result` holds the
        wear steps finished before.
    """
    if fidelity is not None:
        scene = scene.replace({"numerics.fidelity": fidelity})
    if scene.wear is None:
        raise SceneError.of("wear", None, "a table [wear]", "use loaded_contact for a scene without wear")
    physics = plan(scene)
    clock = _Clock()
    teeth = physics.loaded_teeth()
    clock.lap("geometry and compliance")
    stepper = physics.wear_stepper(teeth)
    states: list[WearState] = []
    stopped = None
    try:
        states.extend(_worn_states(physics, teeth, stepper, progress or NoProgress()))
    except ConvergenceError as error:
        if not states:
            raise
        stopped = error
    clock.lap("contact and wear")
    tree = _result(physics, teeth, stepper, states, clock)
    if stopped is not None:
        text = f"{stopped} (stopped after {len(states) - 1} wear steps; they are kept in the error's `result`)"
        raise ConvergenceError(text, tree) from stopped
    return tree


def _worn_states(physics: Plan, teeth: LoadedTeeth, stepper: WearStepper, progress: Progress) -> Iterator[WearState]:
    """The unworn state and one after each wear step."""
    wear = physics.scene.wear
    assert wear is not None
    state = stepper.start()
    yield state
    if wear.until.control_depths_um is not None:
        point = physics.control_point(teeth)
        assert point is not None
        depths = [1e-3 * depth for depth in wear.until.control_depths_um]
        for k, depth in enumerate(depths):
            state = stepper.step_to_depth(state, point, depth)
            progress.step(k + 1, len(depths), f"{1e3 * depth:g} um at the control point")
            yield state
        return
    assert wear.until.meshes is not None
    steps = physics.scene.numerics.wear_steps
    count = _steps_for(stepper, state, wear.until.meshes) if steps == "auto" else int(steps)
    for k in range(count):
        state = stepper.step(state, wear.until.meshes / count)
        progress.step(k + 1, count, f"{state.meshes:.3g} meshes, {1e3 * state.wear.max():.3g} um at most")
        yield state


def _steps_for(stepper: WearStepper, start: WearState, meshes: float) -> int:
    """Wear steps for a run: its greatest depth, estimated with a single step, over a usual depth a step."""
    depth = float(stepper.step(start, meshes).wear.max())
    return int(np.clip(np.ceil(depth / _DEPTH_A_STEP), *_AUTO_STEPS))


def _result(
    physics: Plan, teeth: LoadedTeeth, stepper: WearStepper, states: list[WearState], clock: _Clock
) -> xr.DataTree:
    contacts = [state.contact for state in states]
    poissons_ratio = physics.scene.material.gear.poissons_ratio
    point = physics.control_point(teeth)
    fresh = fresh_sweep(teeth.pair, teeth.lines)
    observers = physics.observers(teeth)
    parts: list[dict[str, collect.Arrays]] = []
    for contact in contacts:
        pressure = teeth.pressures(contact)
        part = {
            "engagement": collect.engagement(teeth, contact, pressure, fresh),
            "mesh_cycle": collect.mesh_cycle(teeth, contact),
        }
        part["history"] = collect.history(teeth, contact, pressure, part)
        part["history"] |= collect.subsurface(teeth, contact, pressure, poissons_ratio)
        engagement, once = collect.observed(teeth, contact, pressure, observers, physics.clock)
        part["engagement"] |= engagement
        part["history"] |= once
        if point is not None:
            part["history"]["wear_depth_control_point"] = np.asarray(1e3 * stepper.depth_at(point, contact.wear))
        part["diagnostics"] = collect.residuals(contact)
        parts.append(part)
    groups = {name: collect.stacked([part[name] for part in parts]) for name in parts[0]}
    groups["flank"] = collect.flank(teeth, fresh) | {"wear_depth": collect.wear_maps(teeth, contacts)}
    groups["flank"] |= collect.contact_patterns(teeth, contacts)
    clock.lap("stress and results")
    groups["diagnostics"] |= {"seconds": np.array(list(clock.seconds.values()))}
    spent = physics.clock.seconds
    if spent:
        groups["diagnostics"] |= {"effect_seconds": np.array(list(spent.values()))}
    coords = collect.coordinates(teeth) | {
        "meshes": np.array([state.meshes for state in states]),
        "stage": np.array(list(clock.seconds)),
    }
    if spent:
        coords["effect"] = np.array(list(spent))
    return build_tree(groups, coords, attributes(physics, "simulate"))


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
    )


class _Clock:
    """Seconds of each stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, stage: str) -> None:
        now = time.perf_counter()
        self.seconds[stage] = now - self._last
        self._last = now
