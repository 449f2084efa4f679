"""What each field of an effect may hold: one line a field, in the order in which a scene is written."""

from __future__ import annotations

from collections.abc import Callable

from semiwear.scene.rule import Rule, advice, at_least_zero, between, choice, positive
from semiwear.scene.values import number, numbers, text

__all__ = ["EFFECT_RULES"]

_SHIFT = "a shift in mm, usually below 0.1; give um divided by 1000"
_TURN = "a rotation in mrad, usually below 1; 1 degree is 17.45 mrad"
_RELIEF = "in um, usually 5 to 100 at a module of some mm; 0 for none"
_SIGNED = "in um, of either sign; usually below 100"
_RELIEF_LENGTH = "a length along the profile, or leave the field out for a third of the flank"
_OIL = "dynamic viscosity in mPa s (cP) at working temperature: 5 to 100 is usual"
_ROUGHNESS = "in um: ground gears have Ra 0.2 to 0.8"
_HARDNESS = "Vickers hardness: about 700 for a case, 300 to 450 for a core; 60 HRC is 697 HV"
_TEMPERATURE = "in degrees Celsius: 60 to 120 is usual"
_SHAFT = "shafts give way in the direction of the load: 0 for rigid, 0.1 to 10 is usual"


def _table(name: str, **rules: Rule) -> dict[str, Rule]:
    return {f"effects.{name}.{field}": rule for field, rule in rules.items()}


def _above(limit: float, high: float, fix: str, unit: str) -> Rule:
    """Greater than one limit, up to another."""
    allowed = f"above {limit:g}, up to {high:g} {unit}".rstrip()
    return Rule(number, allowed, lambda value: limit < value <= high, advice(fix))


def _grid_file() -> Rule:
    def is_grid(path: str) -> bool:
        return path.casefold().endswith((".csv", ".nc"))

    fix = "save the grid as CSV or netCDF, and give its path with the ending .csv or .nc"
    return Rule(text, "the path of a CSV (.csv) or netCDF (.nc) file of deviations", is_grid, advice(fix), is_grid)


def _positive_list(allowed: str, fix: str, shares: bool = False) -> Rule:
    def holds(values: tuple[float, ...]) -> bool:
        return bool(values) and min(values) > 0.0 and (not shares or max(values) <= 1.0)

    return Rule(numbers, allowed, holds, _without(lambda value: value <= 0.0, fix))


def _without(unwanted: Callable[[float], bool], fix: str) -> Callable[[tuple[float, ...]], str]:
    """The remedy, with the first entry of the list that is wrong."""

    def with_entry(values: tuple[float, ...]) -> str:
        wrong = next((k for k, value in enumerate(values) if unwanted(value)), None)
        return fix if wrong is None else f"entry {wrong + 1} is {values[wrong]:g}: {fix}"

    return with_entry


def _pitch_deviations() -> Rule:
    limit = 1000.0

    def holds(values: tuple[float, ...]) -> bool:
        return len(values) >= 2 and all(abs(value) <= limit for value in values)

    def fix(values: tuple[float, ...]) -> str:
        if len(values) < 2:
            return "one value for each of several successive teeth, e.g. [0, 10, 0, -10]"
        return _without(lambda value: abs(value) > limit, "in um; 10 is usual at quality 6")(values)

    return Rule(numbers, f"two or more deviations in um, each {-limit:g} to {limit:g}", holds, fix)


def _modification(body: str) -> dict[str, Rule]:
    return _table(
        f"modification.{body}",
        tip_relief_um=between(number, 0.0, 1000.0, _RELIEF, "um"),
        tip_relief_length_mm=positive(_RELIEF_LENGTH),
        root_relief_um=between(number, 0.0, 1000.0, _RELIEF, "um"),
        root_relief_length_mm=positive(_RELIEF_LENGTH),
        relief_shape=choice("parabolic", "linear"),
        crowning_um=between(
            number, 0.0, 1000.0, "what the ends of the face lose; for a hollow flank give a file", "um"
        ),
        lead_slope_um=between(number, -1000.0, 1000.0, _SIGNED, "um"),
        bias_um=between(number, -1000.0, 1000.0, _SIGNED, "um"),
        file=_grid_file(),
    )


EFFECT_RULES: dict[str, Rule] = {
    **_table(
        "misalignment",
        offset_mm=between(number, -5.0, 5.0, _SHIFT, "mm"),
        axial_pinion_mm=between(number, -5.0, 5.0, _SHIFT, "mm"),
        axial_gear_mm=between(number, -5.0, 5.0, _SHIFT, "mm"),
        shaft_angle_error_mrad=between(number, -50.0, 50.0, _TURN, "mrad"),
        pinion_slope_mrad=between(number, -50.0, 50.0, _TURN, "mrad"),
    ),
    **_modification("pinion"),
    **_modification("gear"),
    **_table("free_edges", strength=between(number, 0.0, 1.0, "the share of the correction: 1 for all of it")),
    **_table(
        "friction",
        law=choice("constant", "iso_14179"),
        coefficient=between(number, 0.0, 1.0, "0.05 is usual with oil, 0.1 to 0.2 without; not in per cent"),
        viscosity_mPas=_above(0.0, 10_000.0, _OIL, "mPa s"),
        roughness_um=_above(0.0, 50.0, _ROUGHNESS, "um"),
    ),
    **_table(
        "flash_temperature",
        model=choice("blok", "tian_kennedy"),
        bulk_temperature_C=between(number, -60.0, 400.0, _TEMPERATURE, "degrees Celsius"),
        friction_coefficient=between(number, 0.0, 1.0, "0.05 is usual with oil; not in per cent"),
        conductivity_W_per_mK=_above(0.0, 1000.0, "about 45 for steel", "W/(m K)"),
        density_kg_per_m3=_above(0.0, 30_000.0, "in kg/m3: 7800 for steel", "kg/m3"),
        specific_heat_J_per_kgK=_above(0.0, 10_000.0, "about 470 for steel", "J/(kg K)"),
    ),
    **_table(
        "lubrication",
        model=choice("dowson_higginson", "hamrock_dowson"),
        viscosity_mPas=_above(0.0, 10_000.0, _OIL, "mPa s"),
        pressure_viscosity_per_GPa=between(
            number, 0.1, 100.0, "per GPa: 15 to 25 for mineral oil, which is 2e-8 per Pa", "per GPa"
        ),
        roughness_um=_above(0.0, 50.0, _ROUGHNESS, "um"),
    ),
    **_table(
        "wear_law.hardness",
        surface_hardness_HV=between(number, 50.0, 2000.0, _HARDNESS, "HV"),
        core_hardness_HV=between(number, 50.0, 2000.0, _HARDNESS, "HV"),
        case_depth_um=_above(0.0, 10_000.0, "in um: nitrided cases are 30 to 600 deep", "um"),
        transition_um=at_least_zero("0 for a sharp step from case to core", "um"),
        pitch_hardness_HV=between(number, 50.0, 2000.0, _HARDNESS, "HV"),
        pitch_band_mm=positive("half the width of the band about the pitch line"),
    ),
    **_table(
        "wear_law.lubrication",
        boundary_lambda=_above(0.0, 100.0, "film thickness over roughness: 0.5 is usual", ""),
        full_film_lambda=_above(0.0, 100.0, "film thickness over roughness: 3 to 4 is usual", ""),
        strength=between(number, 0.0, 1.0, "the share of wear that a full film prevents: 1 for all of it"),
    ),
    **_table(
        "wear_law.temperature",
        activation_energy_kJ_per_mol=between(number, 0.0, 1000.0, "in kJ/mol: 10 to 100 is usual", "kJ/mol"),
        reference_temperature_C=between(number, -60.0, 400.0, _TEMPERATURE, "degrees Celsius"),
    ),
    **_table(
        "wear_law.load",
        exponent=between(number, -2.0, 4.0, "0 is Archard's law; 0.5 to 1 is usual where load makes wear worse"),
        reference_pressure_MPa=_above(
            0.0, 10_000.0, "in MPa: the pressure of the test that gave the coefficient", "MPa"
        ),
    ),
    **_table(
        "load_spectrum",
        torques_Nm=_positive_list("one or more torques, each greater than 0 N m", "give the size of the torque"),
        shares=_positive_list(
            "as many shares as torques, each above 0 and up to 1, summing to 1",
            "leave out what never occurs; not in per cent",
            shares=True,
        ),
    ),
    **_table("pitch_error", pinion_um=_pitch_deviations()),
    **_table(
        "shaft_compliance",
        offset_um_per_kN=between(number, 0.0, 1000.0, _SHAFT, "um/kN"),
        axial_pinion_um_per_kN=between(number, 0.0, 1000.0, _SHAFT, "um/kN"),
        axial_gear_um_per_kN=between(number, 0.0, 1000.0, _SHAFT, "um/kN"),
        shaft_angle_mrad_per_kNm=between(number, 0.0, 1000.0, _SHAFT, "mrad/kNm"),
        pinion_slope_mrad_per_kNm=between(number, 0.0, 1000.0, _SHAFT, "mrad/kNm"),
    ),
    **_table(
        "run_life",
        depth_limit_um=_above(0.0, 10_000.0, "in um: the case depth is a usual limit", "um"),
        body=choice("gear", "pinion"),
    ),
}
