"""Tables of effects of friction, heat and oil, and on the wear coefficient; exported by `semiwear.scene.effects`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar

from semiwear.scene.effect_table import EffectTable

__all__ = [
    "FlashTemperature",
    "Friction",
    "HardnessLaw",
    "LoadLaw",
    "Lubrication",
    "LubricationLaw",
    "TemperatureLaw",
]

_SPEED = "operation.pinion_speed_rpm"


@dataclass(frozen=True, kw_only=True)
class Friction(EffectTable):
    """Table ``[effects.friction]``: sliding friction between the flanks.

    Where sliding all but vanishes the flanks stick in part, and the friction force passes through zero continuously.

    Attributes
    ----------
    law : str
        ``"constant"`` (default) or ``"iso_14179"``, which needs ``operation.pinion_speed_rpm``.
    coefficient : float
        Coefficient of friction of the constant law. Default 0.05.
    viscosity_mPas : float
        Dynamic viscosity of the oil at working temperature. Default 15.
    roughness_um : float
        Mean Ra of both flanks. Default 0.8.
    """

    title: ClassVar[str] = "friction"
    acts_in: ClassVar[str] = "contact"
    needs_if: ClassVar[Mapping[tuple[str, Any], tuple[str, ...]]] = MappingProxyType(
        {("law", "iso_14179"): (_SPEED,)}
    )
    validity: ClassVar[str] = "iso_14179: mineral oil, 1 to 50 m/s at the pitch line, line loads above 150 N/mm"
    references: ClassVar[tuple[str, ...]] = (
        "Coulomb 1785 (constant coefficient)",
        "Carter 1926; Johnson 1985, section 8.3 (friction force where sliding vanishes)",
        "Schlenk 1994, and ISO/TR 14179-2:2001 (mean coefficient of friction of a mesh)",
    )

    law: str = "constant"
    coefficient: float = 0.05
    viscosity_mPas: float = 15.0
    roughness_um: float = 0.8


@dataclass(frozen=True, kw_only=True)
class FlashTemperature(EffectTable):
    """Table ``[effects.flash_temperature]``: frictional heat in the contact.

    Attributes
    ----------
    model : str
        ``"blok"`` (default) or ``"tian_kennedy"``.
    bulk_temperature_C : float
        Temperature of the teeth before they meet. Default 80.
    friction_coefficient : float
        Used where the scene has no ``[effects.friction]``. Default 0.05.
    conductivity_W_per_mK, density_kg_per_m3, specific_heat_J_per_kgK : float
        Of both bodies. Defaults 45, 7800, 470: steel.
    """

    title: ClassVar[str] = "flash temperature"
    acts_in: ClassVar[str] = "contact"
    needs: ClassVar[tuple[str, ...]] = (_SPEED,)
    validity: ClassVar[str] = "heat that does not spread along the face; blok: Peclet numbers above 5"
    references: ClassVar[tuple[str, ...]] = (
        "Blok 1937, Proc. General Discussion on Lubrication 2, 222-235 (moving band of heat)",
        "Tian and Kennedy 1994, J. Tribology 116, 167-174 (any speed)",
    )

    model: str = "blok"
    bulk_temperature_C: float = 80.0
    friction_coefficient: float = 0.05
    conductivity_W_per_mK: float = 45.0
    density_kg_per_m3: float = 7800.0
    specific_heat_J_per_kgK: float = 470.0


@dataclass(frozen=True, kw_only=True)
class Lubrication(EffectTable):
    """Table ``[effects.lubrication]``: thickness of the oil film against roughness.

    Attributes
    ----------
    model : str
        ``"dowson_higginson"`` (default, line contact) or ``"hamrock_dowson"`` (elliptical contact).
    viscosity_mPas : float
        Dynamic viscosity of the oil at working temperature and ambient pressure. Default 15.
    pressure_viscosity_per_GPa : float
        Pressure-viscosity coefficient. Default 20, a mineral oil.
    roughness_um : float
        Composite root mean square roughness of both flanks. Default 0.8.
    """

    title: ClassVar[str] = "oil film"
    acts_in: ClassVar[str] = "contact"
    needs: ClassVar[tuple[str, ...]] = (_SPEED,)
    validity: ClassVar[str] = "flooded, isothermal elastohydrodynamic contact of smooth surfaces, Newtonian oil"
    references: ClassVar[tuple[str, ...]] = (
        "Dowson and Higginson 1966, Elasto-Hydrodynamic Lubrication (minimum film of a line contact)",
        "Hamrock and Dowson 1977, J. Lubr. Technol. 99, 264-276 (minimum film of an elliptical contact)",
    )

    model: str = "dowson_higginson"
    viscosity_mPas: float = 15.0
    pressure_viscosity_per_GPa: float = 20.0
    roughness_um: float = 0.8


@dataclass(frozen=True, kw_only=True)
class HardnessLaw(EffectTable):
    """Table ``[effects.wear_law.hardness]``: wear is inversely proportional to the hardness at the worn depth.

    Attributes
    ----------
    surface_hardness_HV, core_hardness_HV : float
        Hardness of case and core. Defaults 700 and 400.
    case_depth_um : float
        Depth of the middle of the transition from case to core. Default 30.
    transition_um : float
        Width over which hardness passes linearly from case to core. Default 0, a sharp step.
    pitch_hardness_HV : float or None
        Hardness of the surface within a band about the pitch line. Default None: as elsewhere.
    pitch_band_mm : float
        Half-width of that band. Default 2.
    """

    title: ClassVar[str] = "wear by hardness"
    acts_in: ClassVar[str] = "wear"
    needs: ClassVar[tuple[str, ...]] = ("wear",)
    validity: ClassVar[str] = "mild wear; the wear coefficient of [wear] is that of the surface hardness"
    references: ClassVar[tuple[str, ...]] = (
        "Archard 1953, Contact and rubbing of flat surfaces (wear over hardness)",
    )

    surface_hardness_HV: float = 700.0
    core_hardness_HV: float = 400.0
    case_depth_um: float = 30.0
    transition_um: float = 0.0
    pitch_hardness_HV: float | None = None
    pitch_band_mm: float = 2.0


@dataclass(frozen=True, kw_only=True)
class LubricationLaw(EffectTable):
    """Table ``[effects.wear_law.lubrication]``: wear falls linearly as the specific film thickness grows.

    Attributes
    ----------
    boundary_lambda : float
        Film thickness over roughness up to which wear is that of ``[wear]``. Default 0.5.
    full_film_lambda : float
        From here on a film carries all. Default 4.
    strength : float
        Share of wear that a full film prevents, 0 to 1. Default 1.
    """

    title: ClassVar[str] = "wear by oil film"
    acts_in: ClassVar[str] = "wear"
    needs: ClassVar[tuple[str, ...]] = ("wear", "effects.lubrication")
    validity: ClassVar[str] = "mixed lubrication; the wear coefficient of [wear] is that of boundary lubrication"
    references: ClassVar[tuple[str, ...]] = (
        "Priest and Taylor 2000, Wear 241, 193-203 (wear coefficient, linear in the film ratio)",
    )

    boundary_lambda: float = 0.5
    full_film_lambda: float = 4.0
    strength: float = 1.0


@dataclass(frozen=True, kw_only=True)
class TemperatureLaw(EffectTable):
    """Table ``[effects.wear_law.temperature]``: the wear coefficient follows contact temperature as Arrhenius has it.

    Attributes
    ----------
    activation_energy_kJ_per_mol : float
        Activation energy. Default 20.
    reference_temperature_C : float
        Temperature at which the wear coefficient is that of ``[wear]``. Default 80.
    """

    title: ClassVar[str] = "wear by temperature"
    acts_in: ClassVar[str] = "wear"
    needs: ClassVar[tuple[str, ...]] = ("wear", "effects.flash_temperature")
    validity: ClassVar[str] = "mild wear governed by one thermally activated process; below scuffing"
    references: ClassVar[tuple[str, ...]] = (
        "Arrhenius 1889, Z. Phys. Chem. 4, 226-248 (rate against temperature)",
        "Quinn 1983, Tribology International 16, 257-271 (oxidative wear)",
    )

    activation_energy_kJ_per_mol: float = 20.0
    reference_temperature_C: float = 80.0


@dataclass(frozen=True, kw_only=True)
class LoadLaw(EffectTable):
    """Table ``[effects.wear_law.load]``: the wear coefficient is a power of contact pressure.

    Attributes
    ----------
    exponent : float
        k is proportional to (pressure / reference pressure) ** exponent. Default 0.5. With an exponent below 0 it is
        constant below a hundredth of the reference pressure.
    reference_pressure_MPa : float
        Pressure at which the wear coefficient is that of ``[wear]``. Default 1000.
    """

    title: ClassVar[str] = "wear by pressure"
    acts_in: ClassVar[str] = "wear"
    needs: ClassVar[tuple[str, ...]] = ("wear",)
    validity: ClassVar[str] = "pressures near those at which the exponent was measured"
    references: ClassVar[tuple[str, ...]] = ("Rhee 1970, Wear 16, 431-445 (wear as a power of load)",)

    exponent: float = 0.5
    reference_pressure_MPa: float = 1000.0
