"""Tables of effects of friction, heat and oil; exported by `semiwear.scene.effects`."""

from __future__ import annotations

from typing import ClassVar

from semiwear.references.named_data import OILS
from semiwear.scene.declare import declared, table
from semiwear.scene.effect_table import EffectTable, NeedsIf
from semiwear.scene.rule import above, between, choice
from semiwear.scene.rules import named_data
from semiwear.scene.values import number
from semiwear.untyped import Value

_SPEED = "operation.pinion_speed_rpm"
_OIL = "dynamic viscosity in mPa s (cP) at working temperature: 5 to 100 is usual"
_ROUGHNESS = "in um: ground gears have Ra 0.2 to 0.8"
_TEMPERATURE = "in degrees Celsius: 60 to 120 is usual"


def _oil() -> Value:
    meaning = "Named oil, which gives its fields that are left out; needs oil_temperature_C."
    return named_data(OILS, meaning)


def _oil_temperature() -> Value:
    meaning = "Temperature of the oil in the mesh, for its viscosity."
    return declared(between(number, -60.0, 200.0, _TEMPERATURE, "degrees Celsius"), meaning, default=None)


@table
class Friction(EffectTable):
    """Table ``[effects.friction]``: sliding friction between the flanks.

    Near zero sliding the contact sticks in part, and the friction force passes through zero continuously.
    """

    title: ClassVar[str] = "friction"
    acts_in: ClassVar[str] = "contact"
    needs_if: ClassVar[NeedsIf] = {("law", "iso_14179"): (_SPEED,)}
    validity: ClassVar[str] = "iso_14179: mineral oil, 1 to 50 m/s at the pitch line, line loads above 150 N/mm"
    references: ClassVar[tuple[str, ...]] = (
        "Coulomb 1785 (constant coefficient)",
        "Carter 1926; Johnson 1985, section 8.3 (friction force where sliding vanishes)",
        "Schlenk 1994, and ISO/TR 14179-2:2001 (mean coefficient of friction of a mesh)",
    )

    law: str = declared(
        choice("constant", "iso_14179"),
        "Law of the coefficient of friction; `iso_14179` needs operation.pinion_speed_rpm.",
        default="constant",
    )
    coefficient: float = declared(
        between(number, 0.0, 1.0, "0.05 is usual with oil, 0.1 to 0.2 without; not in per cent"),
        "Coefficient of friction of the constant law.",
        default=0.05,
    )
    data: str | None = _oil()
    oil_temperature_C: float | None = _oil_temperature()
    viscosity_mPas: float = declared(
        above(0.0, 10_000.0, _OIL, "mPa s"), "Dynamic viscosity of the oil at working temperature.", default=15.0
    )
    roughness_um: float = declared(above(0.0, 50.0, _ROUGHNESS, "um"), "Mean Ra of both flanks.", default=0.8)


@table
class FlashTemperature(EffectTable):
    """Table ``[effects.flash_temperature]``: frictional heat in the contact."""

    title: ClassVar[str] = "flash temperature"
    acts_in: ClassVar[str] = "contact"
    needs: ClassVar[tuple[str, ...]] = (_SPEED,)
    validity: ClassVar[str] = "no heat conduction along the face; blok: Peclet numbers above 5"
    references: ClassVar[tuple[str, ...]] = (
        "Blok 1937, Proc. General Discussion on Lubrication 2, 222-235 (moving band of heat)",
        "Tian and Kennedy 1994, J. Tribology 116, 167-174 (any speed)",
    )

    model: str = declared(choice("blok", "tian_kennedy"), "Model of the flash temperature.", default="blok")
    bulk_temperature_C: float = declared(
        between(number, -60.0, 400.0, _TEMPERATURE, "degrees Celsius"),
        "Bulk temperature of the teeth before they mesh.",
        default=80.0,
    )
    friction_coefficient: float = declared(
        between(number, 0.0, 1.0, "0.05 is usual with oil; not in per cent"),
        "Coefficient of friction for the heat if the scene has no ``[effects.friction]``.",
        default=0.05,
    )
    conductivity_W_per_mK: float = declared(
        above(0.0, 1000.0, "about 45 for steel", "W/(m K)"), "Thermal conductivity of both bodies.", default=45.0
    )
    density_kg_per_m3: float = declared(
        above(0.0, 30_000.0, "in kg/m3: 7800 for steel", "kg/m3"), "Density of both bodies.", default=7800.0
    )
    specific_heat_J_per_kgK: float = declared(
        above(0.0, 10_000.0, "about 470 for steel", "J/(kg K)"),
        "Specific heat capacity of both bodies.",
        default=470.0,
    )


@table
class Lubrication(EffectTable):
    """Table ``[effects.lubrication]``: thickness of the oil film against roughness."""

    title: ClassVar[str] = "oil film"
    acts_in: ClassVar[str] = "contact"
    needs: ClassVar[tuple[str, ...]] = (_SPEED,)
    validity: ClassVar[str] = "flooded, isothermal elastohydrodynamic contact of smooth surfaces, Newtonian oil"
    references: ClassVar[tuple[str, ...]] = (
        "Dowson and Higginson 1966, Elasto-Hydrodynamic Lubrication (minimum film of a line contact)",
        "Hamrock and Dowson 1977, J. Lubr. Technol. 99, 264-276 (minimum film of an elliptical contact)",
    )

    model: str = declared(
        choice("dowson_higginson", "hamrock_dowson"),
        "Formula of the least film thickness: of a line contact, or of an elliptical one.",
        default="dowson_higginson",
    )
    data: str | None = _oil()
    oil_temperature_C: float | None = _oil_temperature()
    viscosity_mPas: float = declared(
        above(0.0, 10_000.0, _OIL, "mPa s"),
        "Dynamic viscosity of the oil at working temperature and ambient pressure.",
        default=15.0,
    )
    pressure_viscosity_per_GPa: float = declared(
        between(number, 0.1, 100.0, "per GPa: 15 to 25 for mineral oil, which is 2e-8 per Pa", "per GPa"),
        "Pressure-viscosity coefficient; the default is that of a mineral oil.",
        default=20.0,
    )
    roughness_um: float = declared(
        above(0.0, 50.0, _ROUGHNESS, "um"), "Composite root mean square roughness of both flanks.", default=0.8
    )
