"""Failure modes of a scene's tables, built on demand; each is imported only if the scene has its table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.loads import SlicePressures
from semiwear.effect_clock import EffectClock
from semiwear.meshing.flank_pair import FlankPair
from semiwear.meshing.point_flank_pair import PointFlankMesh
from semiwear.meshing.point_flank_sections import normal_module as module_of_points
from semiwear.plan import effects
from semiwear.plan.kept_lines import middle_contact
from semiwear.scene import CylindricalPair, FaceGearPair, Scene
from semiwear.scene.rating_tables import RatingTable
from semiwear.untyped import Value
from semiwear.wear.stepping import WearState, WearStepper

if TYPE_CHECKING:
    from semiwear.contact.flash_temperature import FlashTemperature
    from semiwear.contact.friction import Friction
    from semiwear.ratings.mode import FailureMode
    from semiwear.scene import effects as tables


Known = tuple[SlicePressures | None, np.ndarray | None]

_AT_EVERY_STEP = "safety", "safety_height", "safety_face", "damage_sum"


def _pitting(table: tables.Pitting, scene: Scene, teeth: LoadedTeeth) -> FailureMode:
    from semiwear.ratings.pitting import PitchPoint, Pitting

    pair = teeth.pair
    middle = middle_contact(pair)
    speed = effects.angular_velocity(scene) * float(np.linalg.norm(pair.driven_velocity(middle.position)[0]))
    radius = 1.0 / float(middle.curvature[0, 1])
    if isinstance(scene.gear_pair, CylindricalPair):
        radius *= abs(float(middle.along[0, 2]))  # cos beta_b: from the normal section to the transverse one
    return Pitting.of(table, PitchPoint(radius, 1e-3 * speed))


def _bending(table: tables.Bending, scene: Scene, teeth: LoadedTeeth) -> FailureMode:
    from semiwear.ratings.bending import Bending

    return Bending.of(table, normal_module(scene, teeth.pair))


def _heat(scene: Scene) -> tuple[FlashTemperature, Friction]:
    flash = effects.flash_temperature(scene)
    assert flash is not None  # a need of the table
    return flash, effects.friction_of_heat(scene)


def _micropitting(table: tables.Micropitting, scene: Scene, teeth: LoadedTeeth) -> FailureMode:
    from semiwear.ratings.micropitting import Micropitting

    return Micropitting.of(table, *_heat(scene), effects.running_in(scene, "micropitting"))


def _scuffing(table: tables.Scuffing, scene: Scene, teeth: LoadedTeeth) -> FailureMode:
    from semiwear.ratings.scuffing import Scuffing

    return Scuffing.of(table, *_heat(scene))


def _flank_fracture(table: tables.FlankFracture, scene: Scene, teeth: LoadedTeeth) -> FailureMode:
    from semiwear.ratings.flank_fracture import FlankFracture

    material = scene.material
    return FlankFracture.of(table, (material.pinion.poissons_ratio, material.gear.poissons_ratio))


MODES: dict[str, Callable[[Value, Scene, LoadedTeeth], FailureMode]] = {
    "pitting": _pitting,
    "bending": _bending,
    "micropitting": _micropitting,
    "scuffing": _scuffing,
    "flank_fracture": _flank_fracture,
}
"""Builders of the failure modes, by the names of their tables below ``[effects]``."""


def normal_module(scene: Scene, pair: FlankPair) -> float:
    """Normal module [mm]; for flanks given as points it follows from their pitch."""
    if isinstance(pair, PointFlankMesh):
        return module_of_points(pair.flanks.driving, pair.flanks.pitch_surfaces[0])
    table = scene.gear_pair
    if isinstance(table, CylindricalPair):
        return table.normal_module_mm
    assert isinstance(table, FaceGearPair)
    return table.module_mm


@dataclass(frozen=True)
class Ratings:
    """Contents of the group `/ratings`: its arrays, the modes, and a description of each mode's factors."""

    arrays: dict[str, np.ndarray]
    modes: tuple[str, ...]
    factors: dict[str, str]

    @property
    def quantities(self) -> dict[str, np.ndarray]:
        """Safeties as reported quantities, by name."""
        from semiwear.results.rating_errors import safeties_of

        return dict(safeties_of(np.array(self.modes), self.arrays["safety"]))


def failure_modes(scene: Scene, teeth: LoadedTeeth) -> dict[str, FailureMode]:
    """The failure modes of a scene, by name."""
    return {name: MODES[name](scene.effects.get(name), scene, teeth) for name in named_modes(scene)}


def named_modes(scene: Scene) -> list[str]:
    """Names of the failure modes that a scene rates."""
    return [name for name, table in scene.effects.present() if isinstance(table, RatingTable)]


def rated_states(
    scene: Scene,
    stepper: WearStepper,
    states: Sequence[WearState],
    hours_per_mesh: float | None,
    clock: EffectClock,
    known: Sequence[Known] = (),
) -> Ratings | None:
    """Ratings of wear states, the first of them unworn; None if the scene rates no failure mode.

    Parameters
    ----------
    scene : Scene
    stepper : WearStepper
        Stepper of the states.
    states : sequence of WearState
    hours_per_mesh : float or None
        None where the scene gives no speed.
    clock : EffectClock
        Measures the seconds of every mode.
    known : sequence of (SlicePressures, root stress or None), optional
        Results of every state's contact, used if that contact is rated.
    """
    modes = failure_modes(scene, stepper.teeth)
    if not modes:
        return None
    from semiwear.ratings.contact import RatedContact, RatedFlanks, WornStep
    from semiwear.ratings.failure import rating_arrays

    solved = known if known and not stepper.cases else [(None, None)] * len(states)
    flanks = RatedFlanks.of(stepper.teeth)
    steps = [
        WornStep(
            state.meshes,
            tuple(
                RatedContact(
                    case.teeth, contact, case.share, flanks, lambda t: effects.speeds_of(scene, t.pair, t.lines), *own
                )
                for case, contact in zip(stepper.load_cases, state.loaded, strict=True)
            ),
        )
        for state, own in zip(states, solved, strict=True)
    ]
    rated = {}
    for name, mode in modes.items():
        with clock.measure(name):
            rated[name] = mode.rate(steps)
    arrays = rating_arrays(modes, rated, steps, hours_per_mesh)
    factors = {
        name: "; ".join(f"{symbol} = {why}" for symbol, why in mode.factors.items()) for name, mode in modes.items()
    }
    return Ratings(arrays, tuple(modes), factors)


def rated_contact(
    scene: Scene,
    stepper: WearStepper,
    state: LoadedState,
    meshes: float,
    hours_per_mesh: float | None,
    clock: EffectClock,
    known: Known,
) -> Ratings:
    """Ratings of one wear state as if its contact had been the same in all meshes, of a scene that rates modes.

    Parameters
    ----------
    scene : Scene
    stepper : WearStepper
        Of the teeth in contact, with the loads of a spectrum.
    state : LoadedState
    meshes : float
        Engagements of one gear tooth so far.
    hours_per_mesh : float or None
        None where the scene gives no speed.
    clock : EffectClock
    known : (SlicePressures, root stress or None)
        Of this contact.
    """
    cases = tuple(case.teeth.load(state.wear, None, state.driving_wear) for case in stepper.cases)
    times = [0.0, meshes] if meshes else [0.0]
    states = [WearState(time, state, cases=cases) for time in times]
    rated = rated_states(scene, stepper, states, hours_per_mesh, clock, [known] * len(times))
    assert rated is not None  # there are modes
    last = {name: rated.arrays[name][:, -1:] for name in _AT_EVERY_STEP}
    last["wear_step_of_failure"] = np.minimum(rated.arrays["wear_step_of_failure"], 0)
    if "hours" in rated.arrays:
        last["hours"] = rated.arrays["hours"][-1:]
    return Ratings(rated.arrays | last, rated.modes, rated.factors)
