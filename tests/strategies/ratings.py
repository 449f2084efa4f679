"""Tables of failure modes with usual data of case-hardened gears, and strategies near them."""

from typing import Any

from hypothesis import strategies as st

import semiwear as sw

PITTING: dict[str, Any] = {
    "pinion_limit_MPa": 1500.0,
    "gear_limit_MPa": 1450.0,
    "pinion_life_curve": "hardened",
    "gear_life_curve": "hardened",
    "viscosity_40_mm2_per_s": 220.0,
    "roughness_Rz_um": 3.0,
}
BENDING: dict[str, Any] = {
    "pinion_limit_MPa": 430.0,
    "gear_limit_MPa": 430.0,
    "pinion_life_curve": "case_hardened",
    "gear_life_curve": "case_hardened",
    "root_roughness_Rz_um": 10.0,
}
RATED: dict[str, Any] = {
    "operation.pinion_speed_rpm": 1500.0,
    "effects.pitting": PITTING,
    "effects.bending": BENDING,
}
"""Changes of a scene that rate both modes."""

RATED_SPUR = sw.load_scene("spur_fzg_c").replace(
    RATED
    | {
        "operation.pinion_torque_Nm": 200.0,
        "numerics.face_slices": 11,
        "numerics.roll_positions": 12,
        "numerics.profile_points": 61,
        "numerics.harmonics": 5,
        "numerics.wear_steps": 2,
    }
)
"""A small scene in which pitting ends the life."""


def pitting_tables() -> st.SearchStrategy[dict[str, Any]]:
    """Tables ``[effects.pitting]``."""
    curves = st.sampled_from(["hardened", "hardened_some_pits", "nitrided", "nitrocarburized"])
    return st.fixed_dictionaries(
        {
            "pinion_limit_MPa": st.floats(300.0, 1650.0),
            "gear_limit_MPa": st.floats(300.0, 1650.0),
            "pinion_life_curve": curves,
            "gear_life_curve": curves,
            "film_factors": st.just("from_oil"),
            "viscosity_40_mm2_per_s": st.floats(20.0, 1000.0),
            "roughness_Rz_um": st.floats(0.5, 10.0),
        },
        optional={
            "life_factor_at_1e10": st.floats(0.85, 1.0),
            "gear_work_hardening_factor": st.floats(1.0, 1.2),
            "size_factor": st.floats(0.7, 1.0),
            "application_factor": st.floats(1.0, 2.0),
            "required_safety": st.floats(0.5, 2.0),
        },
    )


def bending_tables() -> st.SearchStrategy[dict[str, Any]]:
    """Tables ``[effects.bending]``."""
    curves = st.sampled_from(
        ["case_hardened", "through_hardened", "normalized", "cast_iron", "nitrided", "nitrocarburized"]
    )
    return st.fixed_dictionaries(
        {
            "pinion_limit_MPa": st.floats(100.0, 525.0),
            "gear_limit_MPa": st.floats(100.0, 525.0),
            "pinion_life_curve": curves,
            "gear_life_curve": curves,
            "root_roughness_Rz_um": st.floats(1.0, 40.0),
        },
        optional={
            "life_factor_at_1e10": st.floats(0.85, 1.0),
            "notch_sensitivity_factor": st.floats(0.7, 1.2),
            "size_factor": st.floats(0.7, 1.0),
            "mean_stress_factor": st.floats(0.4, 1.0),
            "dynamic_factor": st.floats(1.0, 1.5),
            "required_safety": st.floats(0.5, 2.0),
        },
    )
