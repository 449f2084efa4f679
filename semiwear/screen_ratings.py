"""Margins of the failure modes of a scene from two wear states: unworn, and the end of the run."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.errors import ConvergenceError
from semiwear.life import hours_per_mesh
from semiwear.meshing.flank_pair import BODIES
from semiwear.plan import Plan, plan
from semiwear.plan.ratings import Ratings
from semiwear.scene import Scene
from semiwear.wear.stepping import WearState, WearStepper

FAILS, NEAR = "fails", "near its limit"
"""Verdicts on a mode whose safety is below the required one, or little above it."""

_NEAR = 1.2  # of the required safety


def nearness(scene: Scene, mode: str) -> str:
    """Verdict on the least safety of a failure mode, unworn or at the end of the run, by one implicit wear step."""
    try:
        rated = _rated(scene)
    except ConvergenceError as error:
        return f"not run: {error}"
    k = rated.modes.index(mode)
    required, safety = float(rated.arrays["required_safety"][k]), rated.arrays["safety"][k]
    if not np.isfinite(safety).any():
        return "nothing rated: only edges bear load"
    step, body = np.unravel_index(int(np.nanargmin(safety)), safety.shape)
    when = "at the end of the run" if step else "unworn"
    least = f"safety of the {BODIES[body]} {safety[step, body]:.3g} {when}, {required:g} required"
    ratio = safety[step, body] / required
    verdict = FAILS if ratio < 1.0 else NEAR if ratio < _NEAR else "far from its limit"
    meshes = float(rated.arrays["meshes_to_failure"][k, body])
    since = "unworn already" if meshes == 0.0 else f"after about {meshes:.3g} meshes"
    return f"{verdict}: {least}" + (f", below it {since}" if np.isfinite(meshes) else "")


@lru_cache(maxsize=1)
def _rated(scene: Scene) -> Ratings:
    """Ratings of the unworn flanks and of those after one implicit step to the end of the run."""
    physics = plan(scene)
    teeth = physics.loaded_teeth()
    stepper, *states = step_to_end(physics, teeth)
    rated = physics.ratings(stepper, states, hours_per_mesh(scene, teeth.pair))
    assert rated is not None
    return rated


def step_to_end(physics: Plan, teeth: LoadedTeeth) -> tuple[WearStepper, WearState, WearState]:
    """The stepper of a run with wear, its unworn state, and that which one implicit step to its end leaves."""
    assert physics.scene.wear is not None
    until = physics.scene.wear.until
    stepper = replace(physics.wear_stepper(teeth), implicit=True)
    start, point = stepper.start(), physics.control_point(teeth)
    if until.control_depths_um is not None and point is not None:
        return stepper, start, stepper.step_to_depth(start, point, 1e-3 * until.control_depths_um[-1])
    return stepper, start, stepper.step(start, float(until.meshes or 0.0))
