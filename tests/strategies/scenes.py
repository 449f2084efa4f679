"""Valid scenes near the shipped one, and placements."""

from __future__ import annotations

import math

from hypothesis import strategies as st

from semiwear.scene import Placement, Scene, load_scene

SHIPPED = load_scene("face_gear_25x160")


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
            "wear.control_point.radius_mm": _between(495.0, 520.0),
            "wear.control_point.height_mm": _between(-5.0, 4.0),
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
                # A face that misses part of the gear must still cover the control points drawn below.
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
