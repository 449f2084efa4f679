"""Unworn local safeties beside global ones of ISO 6336, for twenty drawn pairs: python -m validation.local_ratings.

Ten spur and ten helical pairs are drawn, with and without tip relief and crowning, and rated twice with the same
material and factors: from the stresses of the standard with all load factors 1 (`validation.iso_rating`), and from
the local pressure and root stress of one mesh cycle. A ratio above 1 is a local safety above the global one. Then one
pair is changed in torque, module, helix angle and relief, one at a time: do both answers go the same way?
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan, cos, radians, tan

import numpy as np
from scipy.optimize import brentq

import semiwear as sw
from semiwear.ratings.bending import bending_curve
from semiwear.ratings.pitting import pitting_curve
from semiwear.scene import CylindricalPair, Scene, scene_from_dict
from semiwear.untyped import Table
from validation.iso_rating import IsoStresses, iso_stresses

_SEED = 6336
_CYCLES = 5e7

PITTING = pitting_curve(1500.0, "hardened", 0.85, 1.0, 1.0)
BENDING = bending_curve(430.0, "case_hardened", 0.85, 1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Compared:
    """A pair rated twice.

    Attributes
    ----------
    scene : Scene
    iso : IsoStresses
    pressure : float [MPa]
        Greatest local contact pressure, away from edges.
    root : (pinion, gear) [MPa]
        Greatest local root stress.
    """

    scene: Scene
    iso: IsoStresses
    pressure: float
    root: tuple[float, float]

    @property
    def pitting(self) -> tuple[float, float]:
        """Global and local S_H of the body whose global one is less."""
        permissible = float(PITTING.permissible(_CYCLES))
        return permissible / max(self.iso.contact), permissible / self.pressure

    @property
    def bending(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Global and local S_F of the pinion and of the gear."""
        permissible = float(BENDING.permissible(_CYCLES))
        return tuple(
            (permissible / one, permissible / own) for one, own in zip(self.iso.root, self.root, strict=True)
        )  # type: ignore[return-value]


def compared(scene: Scene) -> Compared:
    """A scene without wear, rated both ways."""
    engagement = sw.loaded_contact(scene)["engagement"].to_dataset()
    root = engagement["root_stress"].max(("wear_step", "roll_position")).values
    pressure = engagement["contact_pressure_max"].where(engagement["contact_pressure_on_edge"] == 0)
    return Compared(scene, iso_stresses(scene), float(pressure.max()), (float(root[0]), float(root[1])))


def _centre_distance(teeth: tuple[int, int], shifts: tuple[float, float], module: float, helix: float) -> float:
    """Centre distance at which the pair has no backlash."""
    alpha_t = atan(tan(radians(20.0)) / cos(radians(helix)))
    wanted = tan(alpha_t) - alpha_t + 2.0 * sum(shifts) / sum(teeth) * tan(radians(20.0))
    working = brentq(lambda angle: tan(angle) - angle - wanted, 0.05, 1.0)
    return float(0.5 * sum(teeth) * module / cos(radians(helix)) * cos(alpha_t) / cos(working))


def _scene(pair: Table, torque: float, relief: float, crowning: float) -> Scene:
    modification = {"tip_relief_um": relief, "crowning_um": crowning}
    data: Table = {
        "gear_pair": {"type": "cylindrical", "pressure_angle_deg": 20.0} | pair,
        "operation": {"pinion_torque_Nm": torque},
    }
    if relief or crowning:
        data["effects"] = {"modification": {"pinion": modification, "gear": {"tip_relief_um": relief}}}
    return scene_from_dict(data, name="drawn pair")


def _pair(teeth: tuple[int, int], shifts: tuple[float, float], module: float, helix: float, width: float) -> Table:
    return {
        "pinion_teeth": teeth[0],
        "gear_teeth": teeth[1],
        "normal_module_mm": module,
        "helix_angle_deg": helix,
        "centre_distance_mm": _centre_distance(teeth, shifts, module, helix),
        "pinion_profile_shift": shifts[0],
        "gear_profile_shift": shifts[1],
        "pinion_face_width_mm": width,
    }


def _torque_for(pair: Table, pressure: float) -> float:
    """Torque at which the nominal contact stress of the standard is a given one [N m]."""
    stress = iso_stresses(_scene(pair, 100.0, 0.0, 0.0)).contact
    return 100.0 * (pressure / max(stress)) ** 2


def drawn_scenes(count: int = 20) -> list[Scene]:
    """Pairs drawn at random, spur and helical in turns."""
    draw = np.random.default_rng(_SEED)
    scenes = []
    for k in range(count):
        z1 = int(draw.integers(18, 32))
        teeth = (z1, round(z1 * float(draw.uniform(1.2, 3.5))))
        module = float(draw.choice([2.0, 2.5, 3.0, 4.0, 5.0, 6.0]))
        helix = 0.0 if k % 2 == 0 else float(draw.uniform(8.0, 25.0))
        shifts = (float(draw.uniform(0.0, 0.4)), float(draw.uniform(-0.2, 0.2)))
        width = module * float(draw.uniform(6.0, 14.0))
        pair = _pair(teeth, shifts, module, helix, width)
        torque = _torque_for(pair, float(draw.uniform(700.0, 1300.0)))
        modified = bool(draw.random() < 0.6)
        relief = float(draw.uniform(5.0, 8.0)) * module if modified else 0.0
        scenes.append(_scene(pair, torque, relief, float(draw.uniform(0.0, 6.0)) if modified else 0.0))
    return scenes


TRENDS: dict[str, tuple[float, ...]] = {
    "torque [N m]": (300.0, 600.0, 1200.0),
    "module [mm]": (3.0, 4.0, 5.0),
    "helix angle [deg]": (0.0, 12.0, 24.0),
    "tip relief [um]": (0.0, 15.0, 40.0),
}
"""What is changed, one at a time, of a pair of 23/47 teeth, module 4 mm, face 40 mm, 600 N m, relief 15 um."""


def trend_scenes(name: str) -> list[Scene]:
    """The pair with each value of a trend."""
    scenes = []
    for value in TRENDS[name]:
        base = {"torque [N m]": 600.0, "module [mm]": 4.0, "helix angle [deg]": 0.0, "tip relief [um]": 15.0}
        base[name] = value
        pair = _pair((23, 47), (0.2, 0.0), base["module [mm]"], base["helix angle [deg]"], 40.0)
        scenes.append(_scene(pair, base["torque [N m]"], base["tip relief [um]"], 0.0))
    return scenes


def main() -> None:
    """Print both comparisons."""
    print(_HEAD)
    rows = []
    for scene in drawn_scenes():
        one = compared(scene)
        rows.append(_ratios(one))
        print(_line(one), flush=True)
    table = np.array(rows)
    for k, name in enumerate(_RATIOS):
        for kind, own in (("spur", table[::2, k]), ("helical", table[1::2, k])):
            print(f"{name:22} {kind:8} local/global: mean {own.mean():.3f}, {own.min():.3f} to {own.max():.3f}")
    for name in TRENDS:
        print(name)
        for value, scene in zip(TRENDS[name], trend_scenes(name), strict=True):
            print(f"  {value:6g} {_line(compared(scene))}", flush=True)


_RATIOS = ("S_H", "S_H less Z_epsilon", "S_F pinion", "S_F gear", "S_F pinion (2006)", "S_F gear (2006)")
_HEAD = "teeth module face helix relief, contact and overlap ratios | S_H iso, local, ratio, less Z_epsilon | "
_HEAD += "S_F pinion | S_F gear | ratios to the 2006 edition"


def _ratios(one: Compared) -> list[float]:
    older = [iso / own for iso, own in zip(one.iso.root_2006, one.root, strict=True)]
    whole = one.pitting[1] / one.pitting[0]
    root = [local / iso for iso, local in one.bending]
    return [whole, whole / one.iso.contact_ratio_factor, *root, *older]


def _line(one: Compared) -> str:
    pair, effects = one.scene.gear_pair, one.scene.effects.modification.pinion
    relief = 0.0 if effects is None else effects.tip_relief_um
    assert isinstance(pair, CylindricalPair)
    shape = f"{pair.pinion_teeth:3}/{pair.gear_teeth:3} m{pair.normal_module_mm:3g} b{pair.pinion_face_width_mm:5.1f}"
    ratios = f"{one.iso.contact_ratio:5.3f} {one.iso.overlap_ratio:5.3f}"
    parts = [f"{shape} {pair.helix_angle_deg:4.1f} deg {relief:4.1f} um {ratios}"]
    found = _ratios(one)
    parts.append(f"{one.pitting[0]:5.3f} {one.pitting[1]:5.3f} {found[0]:5.3f} {found[1]:5.3f}")
    parts += [f"{iso:5.3f} {local:5.3f} {local / iso:5.3f}" for iso, local in one.bending]
    parts.append(f"{found[4]:5.3f} {found[5]:5.3f}")
    return " | ".join(parts)


if __name__ == "__main__":
    main()
