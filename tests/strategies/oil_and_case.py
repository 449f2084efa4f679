"""Tables of micropitting, scuffing and flank fracture with usual data, and strategies near them."""

from typing import Any

from hypothesis import strategies as st

_BODIES = "pinion", "gear"
OIL: dict[str, Any] = {
    "oil_family": "mineral",
    "viscosity_40_mm2_per_s": 220.0,
    "viscosity_100_mm2_per_s": 19.0,
    "density_15_kg_per_m3": 890.0,
}
_CASE = {"surface_hardness_HV": 700.0, "core_hardness_HV": 400.0, "case_depth_mm": 0.8}

MICROPITTING: dict[str, Any] = OIL | {"bulk_temperature_C": 90.0, "roughness_Ra_um": 0.5, "load_stage": 9.0}
SCUFFING: dict[str, Any] = OIL | {
    "oil_temperature_C": 70.0,
    "oil_supply": "dip",
    "load_stage": 12.0,
    "structural_factor": 1.0,
}
FLANK_FRACTURE: dict[str, Any] = {f"{body}_{name}": value for body in _BODIES for name, value in _CASE.items()}
OIL_AND_CASE: dict[str, Any] = {
    "effects.micropitting": MICROPITTING,
    "effects.scuffing": SCUFFING,
    "effects.flank_fracture": FLANK_FRACTURE,
}
"""Changes of a scene that rate these modes, beside a flash temperature."""


_OILS = {
    "oil_family": st.sampled_from(["mineral", "polyalphaolefin", "polyglycol"]),
    "viscosity_40_mm2_per_s": st.floats(60.0, 600.0),
    "viscosity_100_mm2_per_s": st.floats(5.0, 50.0),
    "density_15_kg_per_m3": st.floats(830.0, 1050.0),
}


def micropitting_tables() -> st.SearchStrategy[dict[str, Any]]:
    """Tables ``[effects.micropitting]``."""
    own = {
        "bulk_temperature_C": st.floats(40.0, 130.0),
        "roughness_Ra_um": st.floats(0.05, 1.5),
        "load_stage": st.floats(5.0, 10.0),
    }
    return st.fixed_dictionaries(
        _OILS | own, optional={"material_factor": st.floats(0.5, 2.0), "required_safety": st.floats(0.5, 2.0)}
    )


def scuffing_tables() -> st.SearchStrategy[dict[str, Any]]:
    """Tables ``[effects.scuffing]``."""
    own = {
        "oil_temperature_C": st.floats(20.0, 100.0),
        "oil_supply": st.sampled_from(["dip", "spray", "submerged"]),
        "load_stage": st.floats(5.0, 13.0),
        "structural_factor": st.floats(0.45, 1.5),
    }
    methods = st.sampled_from(["flash_temperature", "integral_temperature"])
    return st.fixed_dictionaries(_OILS | own, optional={"method": methods, "dynamic_factor": st.floats(1.0, 1.5)})


def flank_fracture_tables() -> st.SearchStrategy[dict[str, Any]]:
    """Tables ``[effects.flank_fracture]``."""
    case = {
        "surface_hardness_HV": st.floats(600.0, 800.0),
        "core_hardness_HV": st.floats(250.0, 480.0),
        "case_depth_mm": st.floats(0.2, 3.0),
    }
    return st.fixed_dictionaries(
        {f"{body}_{name}": values for body in _BODIES for name, values in case.items()},
        optional={"material_factor": st.floats(0.8, 1.2), "application_factor": st.floats(1.0, 2.0)},
    )
