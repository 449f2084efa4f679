"""Units of a scene's fields: the name of a field ends in its unit."""

from __future__ import annotations

UNITS = {
    "mm2_per_N": "mm^2/N",
    "um_per_kN": "um/kN",
    "mrad_per_kNm": "mrad/(kN m)",
    "W_per_mK": "W/(m K)",
    "kg_per_m3": "kg/m^3",
    "J_per_kgK": "J/(kg K)",
    "kJ_per_mol": "kJ/mol",
    "per_GPa": "1/GPa",
    "mPas": "mPa s",
    "MPa": "MPa",
    "Nm": "N m",
    "rpm": "rpm",
    "mm": "mm",
    "um": "um",
    "deg": "deg",
    "mrad": "mrad",
    "C": "degC",
    "HV": "HV",
    "hours": "h",
}
"""Units as written in results, by the ends of fields' names; longer ends come before those that they contain."""

LIFE_UNITS = ("meshes", "hours", "km")
"""Units of a life: engagements of a gear tooth, running time, sliding distance of a flank."""


def unit_of(key: str) -> str:
    """Unit of a field by its dotted key, as written in results: ``"1"`` for a pure number."""
    name = f"_{key.rpartition('.')[2]}"
    return next((unit for end, unit in UNITS.items() if name.endswith(f"_{end}")), "1")
