"""Valid scenes near the shipped one, their effects, and placements."""

import math
from typing import Any

from hypothesis import strategies as st

from semiwear.references.named_data import MATERIALS, OILS, WEAR, named_sets
from semiwear.scene import EFFECTS, Placement, Scene
from tests.scenes import SHIPPED
from tests.strategies.oil_and_case import flank_fracture_tables, micropitting_tables, scuffing_tables
from tests.strategies.ratings import bending_tables, pitting_tables


def _between(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_nan=False, allow_infinity=False)


def _wear_changes() -> st.SearchStrategy[dict[str, object]]:
    """No wear, wear until a number of meshes, or wear until depths at the control point."""
    coefficient = _between(-15.0, -11.0).map(lambda exponent: math.pow(10.0, exponent))
    depths = st.lists(_between(1.0, 60.0), min_size=1, max_size=4, unique=True).map(sorted)
    until_meshes = st.fixed_dictionaries(
        {
            "wear.coefficient_mm2_per_N": coefficient,
            "wear.until.meshes": _between(1e6, 1e12),
            "numerics.wear_steps": st.one_of(st.just("auto"), st.integers(1, 4)),
        },
        optional={"wear.control_point": st.none()},
    )
    until_depths = st.fixed_dictionaries(
        {
            "wear.coefficient_mm2_per_N": coefficient,
            "wear.until.control_depths_um": depths,
            # on the active flank of every pair drawn below: from -4.48 mm on where the pinion's tip edge is round
            "wear.control_point.radius_mm": _between(495.0, 520.0),
            "wear.control_point.height_mm": _between(-4.4, 4.0),
        }
    )
    return st.one_of(st.just({"wear": None}), until_meshes, until_depths)


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    """Face gear scenes in a moderate neighbourhood of the shipped one, small enough to compute."""
    changes = draw(
        st.fixed_dictionaries(
            {
                "operation.pinion_torque_Nm": _between(50.0, 3000.0),
                "operation.loaded_flank": st.sampled_from(["drive", "coast"]),
                "gear_pair.pinion_face_width_mm": _between(60.0, 80.0),
                "gear_pair.pinion_tip_edge_radius_mm": _between(0.0, 0.5),
                "gear_pair.gear_tip_edge_radius_mm": _between(0.0, 0.5),
                "gear_pair.pinion_end_edge_radius_mm": _between(0.0, 1.0),
                "gear_pair.gear_end_edge_radius_mm": _between(0.0, 1.0),
                "gear_pair.pinion_bore_radius_mm": _between(35.0, 60.0),
                "gear_pair.gear_rim_thickness_mm": _between(8.0, 25.0),
                "material.gear.youngs_modulus_MPa": _between(70000.0, 220000.0),
                "material.gear.poissons_ratio": _between(0.2, 0.4),
                "numerics.roll_positions": st.integers(8, 12),
                "numerics.face_slices": st.integers(7, 21),
                "numerics.profile_points": st.integers(21, 41),
                "numerics.harmonics": st.integers(1, 9),
                "numerics.tooth_compliance": st.sampled_from(["prism", "rigid"]),
                "numerics.tooth_pairs": st.one_of(st.just("auto"), st.integers(3, 5)),
                # a face that misses part of the gear must still cover the control points drawn above
                "gear_pair.pinion_centre_mm": _between(515.0, 523.0),
            }
        )
    )
    return SHIPPED.replace(changes | draw(_wear_changes()))


def placements() -> st.SearchStrategy[Placement]:
    """Mounting errors of up to 0.2 mm and 1 mrad."""
    shift, turn = _between(-0.2, 0.2), _between(-1.0, 1.0)
    return st.builds(
        Placement,
        offset_mm=shift,
        axial_pinion_mm=shift,
        axial_gear_mm=shift,
        shaft_angle_error_mrad=turn,
        pinion_slope_mrad=turn,
    )


def _optional(**fields: st.SearchStrategy[Any]) -> st.SearchStrategy[dict[str, Any]]:
    """A table with any of these fields."""
    return st.fixed_dictionaries({}, optional=fields)


def _modification() -> st.SearchStrategy[dict[str, Any]]:
    relief, signed, length = _between(0.0, 50.0), _between(-20.0, 20.0), _between(1.0, 4.0)
    return _optional(
        tip_relief_um=relief,
        tip_relief_length_mm=length,
        root_relief_um=relief,
        root_relief_length_mm=length,
        relief_shape=st.sampled_from(["parabolic", "linear"]),
        crowning_um=relief,
        lead_slope_um=signed,
        bias_um=signed,
    )


@st.composite
def _load_spectra(draw: st.DrawFn, torque: float) -> dict[str, Any]:
    parts = draw(st.lists(st.integers(1, 9), min_size=1, max_size=3))
    factors = draw(st.lists(_between(0.5, 1.5), min_size=len(parts), max_size=len(parts)))
    return {"torques_Nm": [factor * torque for factor in factors], "shares": [part / sum(parts) for part in parts]}


def effect_tables(scene: Scene = SHIPPED) -> dict[str, st.SearchStrategy[dict[str, Any]]]:
    """For every effect that this scene can have, its table with moderate values; named as in `EFFECTS`."""
    shift, turn, compliance = _between(-0.2, 0.2), _between(-1.0, 1.0), _between(0.0, 5.0)
    viscosity, roughness, hardness = _between(5.0, 100.0), _between(0.1, 2.0), _between(300.0, 800.0)
    worn = () if scene.wear is None else scene.wear.worn_bodies
    tables = {
        "misalignment": _optional(
            offset_mm=shift,
            axial_pinion_mm=shift,
            axial_gear_mm=shift,
            shaft_angle_error_mrad=turn,
            pinion_slope_mrad=turn,
        ),
        "modification.pinion": _modification(),
        "modification.gear": _modification(),
        "free_edges": _optional(strength=_between(0.0, 1.0)),
        "friction": _optional(
            law=st.sampled_from(["constant", "iso_14179"]),
            coefficient=_between(0.0, 0.2),
            viscosity_mPas=viscosity,
            roughness_um=roughness,
        ),
        "flash_temperature": _optional(
            model=st.sampled_from(["blok", "tian_kennedy"]),
            bulk_temperature_C=_between(20.0, 150.0),
            friction_coefficient=_between(0.0, 0.2),
            conductivity_W_per_mK=_between(20.0, 60.0),
            density_kg_per_m3=_between(7000.0, 8000.0),
            specific_heat_J_per_kgK=_between(400.0, 600.0),
        ),
        "lubrication": _optional(
            model=st.sampled_from(["dowson_higginson", "hamrock_dowson"]),
            viscosity_mPas=viscosity,
            pressure_viscosity_per_GPa=_between(10.0, 30.0),
            roughness_um=roughness,
        ),
        "wear_law.hardness": _optional(
            surface_hardness_HV=hardness,
            core_hardness_HV=hardness,
            case_depth_um=_between(20.0, 100.0),
            transition_um=_between(0.0, 40.0),
            pitch_hardness_HV=hardness,
            pitch_band_mm=_between(0.5, 3.0),
        ),
        "wear_law.lubrication": _optional(
            boundary_lambda=_between(0.1, 1.0),
            full_film_lambda=_between(2.0, 5.0),
            strength=_between(0.0, 1.0),
        ),
        "wear_law.temperature": _optional(
            activation_energy_kJ_per_mol=_between(0.0, 50.0), reference_temperature_C=_between(40.0, 120.0)
        ),
        "wear_law.load": _optional(exponent=_between(-0.5, 1.5), reference_pressure_MPa=_between(500.0, 1500.0)),
        "running_in": st.fixed_dictionaries(
            {"acts_on": st.just("wear_law")},
            optional={"strength": _between(0.0, 0.9), "depth_um": _between(0.1, 10.0)},
        ),
        "load_spectrum": _load_spectra(scene.operation.pinion_torque_Nm),
        "pitch_error": st.fixed_dictionaries({"pinion_um": st.lists(_between(-20.0, 20.0), min_size=2, max_size=5)}),
        "shaft_compliance": _optional(
            offset_um_per_kN=compliance,
            axial_pinion_um_per_kN=compliance,
            axial_gear_um_per_kN=compliance,
            shaft_angle_mrad_per_kNm=_between(0.0, 0.5),
            pinion_slope_mrad_per_kNm=_between(0.0, 0.5),
        ),
        "pitting": pitting_tables(),
        "bending": bending_tables(),
        "micropitting": micropitting_tables(),
        "scuffing": scuffing_tables(),
        "flank_fracture": flank_fracture_tables(),
        "run_life": st.fixed_dictionaries(
            {"body": st.sampled_from(worn or ("gear",))}, optional={"depth_limit_um": _between(5.0, 100.0)}
        ),
    }
    if scene.numerics.tooth_compliance == "rigid":
        del tables["bending"]  # rigid teeth have no root stress
    return {name: table for name, table in tables.items() if worn or "wear" not in EFFECTS[name].needs}


@st.composite
def effects(draw: st.DrawFn, scene: Scene = SHIPPED) -> dict[str, Any]:
    """Changes for `Scene.replace` that add any effects that this scene can have, and what they need."""
    tables = effect_tables(scene)
    chosen = draw(st.lists(st.sampled_from(sorted(tables)), unique=True))
    changes: dict[str, Any] = {}
    while chosen:
        name = chosen.pop()
        table = draw(tables[name])
        changes[f"effects.{name}"] = table
        needs = [*EFFECTS[name].needs]
        for (field, value), more in EFFECTS[name].needs_if.items():
            needs += more if table.get(field) == value else ()
        for need in needs:
            if need == "operation.pinion_speed_rpm":
                changes[need] = draw(_between(100.0, 6000.0))
            elif need.removeprefix("effects.") in EFFECTS and need not in changes:
                chosen.append(need.removeprefix("effects."))
    return changes


def named_changes() -> st.SearchStrategy[dict[str, object]]:
    """Named data of every kind, and a run that ends after hours."""
    names = {kind: st.sampled_from(list(named_sets(kind))) for kind in (MATERIALS, WEAR, OILS)}
    oil = st.fixed_dictionaries({"data": names[OILS], "oil_temperature_C": _between(0.0, 120.0)})
    return st.fixed_dictionaries(
        {
            "material.gear": names[MATERIALS],
            "wear.coefficient_mm2_per_N": st.none(),
            "wear.data": st.one_of(names[WEAR], st.fixed_dictionaries({"gear": names[WEAR]})),
            "wear.until.hours": _between(1.0, 1e5),
            "operation.pinion_speed_rpm": _between(1.0, 1e4),
            "effects.lubrication": oil,
            "effects.friction": oil,
        }
    )
