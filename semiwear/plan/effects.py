"""Physics of a scene's tables under `[effects]`, built on demand.

A module is imported only if the scene has its table: absent physics is neither constructed nor loaded.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from functools import lru_cache
from math import pi
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.compliance.elastic_teeth import CompliantBody, ElasticTeeth
from semiwear.compliance.slice_compliance import SliceCompliance
from semiwear.contact.fidelity import Fidelity
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.effect_clock import EffectClock
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import FlankGrid
from semiwear.meshing.flank_pair import DRIVEN, DRIVING, FlankPair
from semiwear.meshing.surface_speed import SurfaceSpeeds
from semiwear.plan.teeth import elastic
from semiwear.scene import Scene

if TYPE_CHECKING:
    from semiwear.contact.film_thickness import FilmThickness
    from semiwear.contact.flash_temperature import FlashTemperature
    from semiwear.contact.friction import Friction
    from semiwear.contact.running_in import RunningIn
    from semiwear.scene.effects import ShaftCompliance
    from semiwear.wear.laws import ContactLaw, HardnessLaw

_UM = 1e-3  # mm


# ---------------------------------------------------------------- shape of the flanks


def deviates(scene: Scene) -> bool:
    """Whether an effect changes the fresh flanks."""
    return any(table.acts_in == "geometry" for _, table in scene.effects.present())


def deviation_depth(scene: Scene, pair: FlankPair, lines: ContactLines, grid: FlankGrid) -> FloatArray | None:
    """Depth of deviations of both flanks at the driven flank's nodes, (1 or roll, face, profile) [mm], or None."""
    from semiwear.meshing.flank_deviations import depth_between

    return depth_between(scene.effects.present(), pair, lines, grid)


def most_set_back(scene: Scene) -> float:
    """Greatest distance by which deviations and pitch errors can set a slice back against another [mm]."""
    error = scene.effects.pitch_error
    total = 0.0 if error is None else _UM * float(np.ptp(error.pinion_um))
    if deviates(scene):
        from semiwear.meshing.flank_deviations import tallest

        total += tallest(scene.effects.present())
    return total


class PitchSequence(NamedTuple):
    """Pitch errors of the teeth in mesh: the gap at each tooth pair [mm], and the share of meshes."""

    gap: FloatArray
    share: float


def pitch_sequences(scene: Scene, pair: FlankPair, pairs: int) -> list[PitchSequence]:
    """All sequences of pitch errors that come into mesh; empty without pitch errors.

    In the first one the tooth that protrudes most is next to the pitch point. A pair one base pitch farther on
    entered one tooth earlier. Equal sequences are merged.
    """
    table = scene.effects.pitch_error
    if table is None:
        return []
    out = _UM * np.asarray(table.pinion_um) * pair.normal_per_arc
    behind = out.max() - out
    most = int(np.argmax(out))
    teeth = np.arange(pairs) - pairs // 2
    counts = Counter(tuple(behind[(most + shift - teeth) % out.size].tolist()) for shift in range(out.size))
    return [PitchSequence(np.array(gap), count / out.size) for gap, count in counts.items()]


# ---------------------------------------------------------------- compliance


def further_compliance(
    scene: Scene,
    pair: FlankPair,
    lines: ContactLines,
    teeth: ElasticTeeth,
    half_width: float,
    clock: EffectClock,
) -> tuple[SliceCompliance, ...]:
    """Additional compliance between slices from effects."""
    further: list[SliceCompliance] = []
    if scene.effects.free_edges is not None:
        with clock.measure("free_edges"):
            further.append(
                _free_edges(scene, scene.effects.free_edges.strength, pair, lines, teeth.bodies, half_width)
            )
    if scene.effects.shaft_compliance is not None:
        with clock.measure("shaft_compliance"):
            further.append(_mounting(scene.effects.shaft_compliance, pair, lines))
    return tuple(further)


def _free_edges(
    scene: Scene,
    strength: float,
    pair: FlankPair,
    lines: ContactLines,
    bodies: tuple[CompliantBody, ...],
    half_width: float,
) -> SliceCompliance:
    from semiwear.compliance.free_edges import FreeEdges

    borders = pair.borders(lines.face, sharp=True)
    return FreeEdges.of(
        lines,
        borders,
        (elastic(scene.material.pinion), elastic(scene.material.gear)),
        (bodies[DRIVING].depth, bodies[DRIVEN].depth) if bodies else None,
        half_width,
        tip_turns=(borders.driving_tip_turn, borders.tip_turn),
        strength=strength,
    )


def _mounting(shafts: ShaftCompliance, pair: FlankPair, lines: ContactLines) -> SliceCompliance:
    from semiwear.compliance.mounting import Mounting, MountingSprings

    springs = MountingSprings(
        offset=1e-6 * shafts.offset_um_per_kN,
        axial_pinion=1e-6 * shafts.axial_pinion_um_per_kN,
        axial_gear=1e-6 * shafts.axial_gear_um_per_kN,
        shaft_angle=1e-9 * shafts.shaft_angle_mrad_per_kNm,
        pinion_slope=1e-9 * shafts.pinion_slope_mrad_per_kNm,
    )
    face = np.broadcast_to(lines.face, lines.profile.shape)
    met = pair.meeting(face, lines.profile, lines.roll[:, None])
    return Mounting(springs, met.position, met.normal, pair.pitch_point)


# ---------------------------------------------------------------- rubbing and oil


def angular_velocity(scene: Scene) -> float:
    """Angular velocity of the pinion [rad/s]; 1 without a speed, on which then nothing depends."""
    speed = scene.operation.pinion_speed_rpm
    return 1.0 if speed is None else speed * pi / 30.0


def speeds_of(scene: Scene, pair: FlankPair, lines: ContactLines) -> SurfaceSpeeds:
    """Velocities in the contact lines at the speed of the scene."""
    return _speeds(pair, lines, angular_velocity(scene))


@lru_cache(maxsize=4)
def _speeds(pair: FlankPair, lines: ContactLines, angular: float) -> SurfaceSpeeds:
    return SurfaceSpeeds.of(pair, lines, angular)


def friction(scene: Scene) -> Friction | None:
    """The friction law, or None."""
    table = scene.effects.friction
    if table is None:
        return None
    from semiwear.contact.friction import Friction

    law = "constant" if table.law == "constant" else "iso_14179"
    return Friction(law, table.coefficient, table.viscosity_mPas, table.roughness_um)  # type: ignore[arg-type]


def rubbing(scene: Scene, pair: FlankPair, lines: ContactLines, fidelity: Fidelity) -> Fidelity:
    """The fidelity with friction in load sharing if the scene has friction; otherwise unchanged."""
    law = friction(scene)
    if law is None:
        return fidelity
    from semiwear.contact.frictional_contact import ROUGHLY, FrictionalContact

    solve = FrictionalContact(fidelity.solve, law, speeds_of(scene, pair, lines))
    return replace(
        fidelity,
        solve=solve,
        roughly=replace(solve, frictionless=fidelity.roughly or fidelity.solve, tolerance=ROUGHLY),
    )


def friction_of_heat(scene: Scene) -> Friction:
    """Friction that heats the flanks: of the scene, or by the coefficient in the flash temperature's table."""
    own = friction(scene)
    if own is not None:
        return own
    from semiwear.contact.friction import Friction

    table = scene.effects.flash_temperature
    assert table is not None
    return Friction("constant", table.friction_coefficient)


def flash_temperature(scene: Scene) -> FlashTemperature | None:
    """The model of the flash temperature, or None."""
    table = scene.effects.flash_temperature
    if table is None:
        return None
    from semiwear.contact.flash_temperature import FlashTemperature

    return FlashTemperature(
        model=table.model,  # type: ignore[arg-type]
        bulk_temperature_C=table.bulk_temperature_C,
        conductivity_W_per_mK=table.conductivity_W_per_mK,
        density_kg_per_m3=table.density_kg_per_m3,
        specific_heat_J_per_kgK=table.specific_heat_J_per_kgK,
    )


def film_thickness(scene: Scene, modulus: float) -> FilmThickness | None:
    """The model of the oil film, or None; `modulus` is E* [MPa]."""
    table = scene.effects.lubrication
    if table is None:
        return None
    from semiwear.contact.film_thickness import FilmThickness

    return FilmThickness(
        model=table.model,  # type: ignore[arg-type]
        viscosity_mPas=table.viscosity_mPas,
        pressure_viscosity_per_GPa=table.pressure_viscosity_per_GPa,
        roughness_um=table.roughness_um,
        effective_modulus=modulus,
    )


def running_in(scene: Scene, of: str) -> RunningIn | None:
    """Model of the running-in of roughness for the film of `of`, ``"wear_law"`` or ``"micropitting"``, or None."""
    table = scene.effects.running_in
    if table is None or table.acts_on not in (of, "both"):
        return None
    from semiwear.contact.running_in import RunningIn

    return RunningIn(table.strength, _UM * table.depth_um)


# ---------------------------------------------------------------- the wear coefficient


@dataclass(frozen=True)
class _ContactPhysics:
    """Models of the contact from a scene's effects (a `ContactPhysics`)."""

    scene: Scene
    modulus: float

    def film(self) -> FilmThickness:
        found = film_thickness(self.scene, self.modulus)
        assert found is not None  # a rule of the scene
        return found

    def flash(self) -> FlashTemperature:
        found = flash_temperature(self.scene)
        assert found is not None  # a rule of the scene
        return found

    def friction(self) -> Friction:
        return friction_of_heat(self.scene)


def contact_laws(scene: Scene, modulus: float) -> dict[str, ContactLaw]:
    """Factors of the wear coefficient that depend on the contact, by the names of their effects."""
    present = {name: table for name, table in scene.effects.present() if name.startswith("wear_law.")}
    if not present:
        return {}
    from semiwear.wear.laws import CONTACT_LAWS

    physics = _ContactPhysics(scene, modulus)
    return {name: CONTACT_LAWS[name](table, physics) for name, table in present.items() if name in CONTACT_LAWS}


def hardness_laws(scene: Scene, teeth: LoadedTeeth) -> tuple[HardnessLaw, HardnessLaw] | None:
    """Hardness laws of the driving and the driven flank, or None."""
    table = scene.effects.wear_law.hardness
    if table is None:
        return None
    from semiwear.wear.laws import HardnessLaw

    law = HardnessLaw(
        surface_hardness=table.surface_hardness_HV,
        core_hardness=table.core_hardness_HV,
        case_depth=_UM * table.case_depth_um,
        transition=_UM * table.transition_um,
    )
    if table.pitch_hardness_HV is None:
        return law, law
    ratio = table.pitch_hardness_HV / table.surface_hardness_HV
    grid = teeth.grid
    distance = np.abs(grid.profile - teeth.pair.pitch_profile(grid.face)[:, None])
    driven = replace(law, surface=np.where(distance <= table.pitch_band_mm, ratio, 1.0))
    if teeth.driving is None:
        return law, driven
    own = teeth.driving.grid
    height, _ = teeth.pair.flank_place(DRIVING, own.face[:, None], own.profile)
    return replace(law, surface=np.where(np.abs(height) <= table.pitch_band_mm, ratio, 1.0)), driven
