"""Unworn, local safeties against micropitting and scuffing beside the standards' global ones for twenty drawn pairs.

Run ``python -m validation.local_films``: two minutes. Spur pairs agree but for load sharing (film -3 to +14 %,
flash temperature -8 to +3 %); the integral temperature is up to 18 % less safe where the ratio is large, for the
standard's mean flash temperature is that of the pinion's tip. Helical pairs come out 1.1 to 1.5 (film) and 1.4 to
1.8 times (flash temperature) as safe: the standards rate the tip with the mean load 1/eps_alpha, but unmodified
helical teeth press their tip edges, and slices within six contact widths along the line of a pressed edge are not
rated. Of the 20/50 pair 75 % of the bearing slices are; the worst of them bears 0.89 of the standard's load at 0.8
of the way to the tip.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import asin, atan, cos, pi, radians, sin, sqrt, tan
from typing import Any

import numpy as np

import semiwear as sw
from semiwear.closed_forms import effective_modulus
from semiwear.ratings.load_stages import film_of_test
from semiwear.ratings.oil import Oil
from semiwear.ratings.scuffing import scuffing_integral_temperature, scuffing_temperature
from semiwear.ratings.specific_film import FilmContact, permissible_film, specific_film

MODULUS = effective_modulus(206e3, 0.3, 206e3, 0.3)
OIL = Oil("mineral", 220.0, 19.0, 890.0)
BULK, OIL_TEMPERATURE, FRICTION, ROUGHNESS = 90.0, 70.0, 0.05, 0.5
HEAT = {"conductivity_W_per_mK": 50.0, "density_kg_per_m3": 7800.0, "specific_heat_J_per_kgK": 3.8e6 / 7800.0}
CONTACT_COEFFICIENT = 435.0  # B_M of that steel, N/(mm^1/2 m^1/2 s^1/2 K)


@dataclass
class Mesh:
    """Unmodified cylindrical gears at the reference centre distance, as the standards rate them.

    ISO/TR 13989-1 (load sharing of clause 9, accuracy grade 7), ISO/TR 13989-2 and method B of ISO/TR 15144-1, all
    with a given coefficient of friction, without the approach factor and with load factors of 1.
    """

    teeth: tuple[int, int]
    module: float
    helix: float
    width: float
    torque: float
    speed: float  # rev/min

    @property
    def scene(self) -> dict[str, Any]:
        """Changes of the shipped spur gears that make this pair."""
        own = {
            "pinion_teeth": self.teeth[0],
            "gear_teeth": self.teeth[1],
            "normal_module_mm": self.module,
            "helix_angle_deg": self.helix,
            "pinion_face_width_mm": self.width,
            "pinion_profile_shift": 0.0,
            "gear_profile_shift": 0.0,
            "centre_distance_mm": None,
        }
        return {f"gear_pair.{name}": value for name, value in own.items()} | {
            "operation.pinion_torque_Nm": self.torque,
            "operation.pinion_speed_rpm": self.speed,
        }

    def __post_init__(self) -> None:
        helix, normal = radians(self.helix), radians(20.0)
        angle = atan(tan(normal) / cos(helix))
        reference = [0.5 * z * self.module / cos(helix) for z in self.teeth]
        base = [r * cos(angle) for r in reference]
        tips = [sqrt((r + self.module) ** 2 - b**2) for r, b in zip(reference, base, strict=True)]
        self.angle, self.base_helix = angle, asin(sin(helix) * cos(normal))
        self.reference, self.tips = reference, tips
        self.pitch = 2.0 * pi * base[0] / self.teeth[0]
        self.action = (reference[0] + reference[1]) * sin(angle)
        self.ratio = self.teeth[1] / self.teeth[0]
        self.load = 1e3 * self.torque / reference[0] / self.width
        self.velocity = 1e-3 * self.speed * pi / 30.0 * reference[0]
        self.addenda = [(t - r * sin(angle)) / self.pitch for t, r in zip(tips, reference, strict=True)]

    @property
    def contact_ratio(self) -> float:
        """Transverse contact ratio."""
        return sum(self.addenda)

    @property
    def overlap(self) -> float:
        """Overlap ratio."""
        return self.width * sin(radians(self.helix)) / (pi * self.module)

    @property
    def helical_load_factor(self) -> float:
        """K_B,gamma."""
        total = min(self.contact_ratio + self.overlap, 3.5)
        return 1.0 if total <= 2.0 else 1.0 + 0.2 * sqrt((total - 2.0) * (5.0 - total))

    def mean_flash(self) -> float:
        """theta_flaint of ISO/TR 13989-2."""
        u, first, (e1, e2) = self.ratio, self.tips[0], self.addenda
        second = self.action - first
        shape = 0.51 * sqrt(u + 1.0) * (sqrt(first) - sqrt(second / u)) / (first * second) ** 0.25
        angle = 1.22 * (sin(self.angle) * cos(radians(20.0)) * cos(radians(self.helix))) ** 0.25 / cos(self.angle)
        distance = sum(self.reference)
        tip = FRICTION * 50.0 * shape * angle * (self.helical_load_factor * self.load) ** 0.75
        total = e1 + e2
        share = (0.7 * (e1**2 + e2**2) - 0.22 * total + 0.52 - 0.6 * e1 * e2) / (2.0 * total * e1)
        return tip * sqrt(self.velocity) / distance**0.25 * share

    def integral_safety(self) -> float:
        """S_intS of dipped gears."""
        mean = self.mean_flash()
        return scuffing_integral_temperature(OIL, 12.0) / (OIL_TEMPERATURE + 2.2 * mean)

    def path(self, points: int) -> np.ndarray:
        """Radii of curvature of the pinion, in the transverse section."""
        return np.linspace(self.action - self.tips[1], self.tips[0], points)

    def sharing(self, first: np.ndarray) -> np.ndarray:
        """X_Gamma of unmodified teeth."""
        entry, leave = first - (self.action - self.tips[1]), self.tips[0] - first
        if self.contact_ratio + self.overlap > 2.0 and self.helix:
            return np.full(first.shape, 1.0 / self.contact_ratio)
        double = (self.contact_ratio - 1.0) * self.pitch
        near = np.minimum(entry, leave)
        return np.where(near < double, (1.0 + near / double) / 3.0, 1.0)

    def flash(self, first: np.ndarray) -> np.ndarray:
        """Blok's flash temperature under the shared load, without the approach factor."""
        load = self.load / cos(self.angle) * self.sharing(first)
        second = self.action - first
        curvature = self.action / (first * second) * cos(self.base_helix)
        width = np.sqrt(4.0 * load / (pi * MODULUS * curvature))
        speeds = [1e-3 * self.speed * pi / 30.0 * r / q for r, q in ((first, 1.0), (second, self.ratio))]
        spread = CONTACT_COEFFICIENT * 1e-3 * (np.sqrt(speeds[0]) + np.sqrt(speeds[1])) * np.sqrt(2.0 * width)
        return 1.11 * FRICTION * load * np.abs(speeds[0] - speeds[1]) / spread

    def flash_safety(self) -> float:
        """S_B of dipped gears."""
        flash = self.flash(self.path(401))
        rise = 0.47 * flash.mean() + flash.max()
        return (scuffing_temperature(OIL, OIL_TEMPERATURE, 12.0) - OIL_TEMPERATURE) / float(rise)

    def film_safety(self) -> float:
        """Method B: the least of the path."""
        first = self.path(401)
        second = self.action - first
        curvature = self.action / (first * second) * cos(self.base_helix)
        load = self.load / cos(self.angle) * self.sharing(first)
        speed = self.speed * pi / 30.0 * (first + second / self.ratio)
        contact = FilmContact(
            speed, np.sqrt(load * MODULUS * curvature / pi), curvature, BULK + self.flash(first), MODULUS
        )
        film = specific_film(contact, OIL, BULK, ROUGHNESS)
        return float(film.min()) / permissible_film(film_of_test(OIL, 9.0))


def drawn() -> list[Mesh]:
    """Twelve spur and eight helical pairs."""
    draw = np.random.default_rng(20261125)
    pairs = []
    for k in range(20):
        z1 = int(draw.integers(18, 36))
        z2 = round(z1 * draw.uniform(1.0, 4.0))
        module, helix = float(draw.choice([2.0, 3.0, 4.0, 6.0])), 0.0 if k < 12 else float(draw.uniform(8.0, 25.0))
        width = module * float(draw.uniform(6.0, 10.0))
        # 60 to 200 N for each millimetre of the face and each millimetre of module
        torque = 1e-3 * 0.5 * z1 * module * width * float(draw.uniform(60.0, 200.0)) * module
        pairs.append(Mesh((z1, z2), module, helix, width, torque, float(draw.uniform(500.0, 3000.0))))
    return pairs


SHEET = {
    "oil_family": OIL.family,
    "viscosity_40_mm2_per_s": OIL.viscosity_40,
    "viscosity_100_mm2_per_s": OIL.viscosity_100,
    "density_15_kg_per_m3": OIL.density_15,
}
BASE = sw.load_scene("spur_fzg_c").replace(
    {
        "numerics.face_slices": 61,
        "numerics.roll_positions": 48,
        "numerics.profile_points": 121,
        "numerics.harmonics": 5,
        "operation.pinion_speed_rpm": 1500.0,
        "effects.flash_temperature": HEAT | {"friction_coefficient": FRICTION},
        "effects.micropitting": SHEET | {"bulk_temperature_C": BULK, "roughness_Ra_um": ROUGHNESS, "load_stage": 9.0},
        "effects.scuffing": SHEET
        | {"oil_temperature_C": OIL_TEMPERATURE, "oil_supply": "dip", "load_stage": 12.0, "structural_factor": 1.0},
    }
)


def compared(mesh: Mesh, changes: Mapping[str, Any] | None = None) -> dict[str, tuple[float, float]]:
    """Global and local safeties, unworn, by their symbols; `changes` are those of the scene."""
    scene = BASE.replace({**mesh.scene, **(changes or {})})
    flash, integral = (
        sw.loaded_contact(scene.replace({"effects.scuffing.method": method}))["ratings"].safety.min(
            ("wear_step", "body")
        )
        for method in ("flash_temperature", "integral_temperature")
    )
    return {
        "S_lambda": (mesh.film_safety(), float(flash.sel(mode="micropitting"))),
        "S_B": (mesh.flash_safety(), float(flash.sel(mode="scuffing"))),
        "S_intS": (mesh.integral_safety(), float(integral.sel(mode="scuffing"))),
    }


def main() -> None:
    """Print local and global safeties of every pair, and their ratio."""
    print("teeth   module  helix  eps_alpha  eps_beta  micropitting       flash temperature  integral temperature")
    for mesh in drawn():
        told = "  ".join(f"{own:5.2f} {theirs:5.2f} {own / theirs:5.3f}" for theirs, own in compared(mesh).values())
        teeth = f"{mesh.teeth[0]}/{mesh.teeth[1]}"
        print(f"{teeth:7} {mesh.module:6g} {mesh.helix:6.1f} {mesh.contact_ratio:10.2f} {mesh.overlap:9.2f}  {told}")


if __name__ == "__main__":
    main()
