"""Helical and spur pairs against finite elements with every tooth: python -m validation.helical_pairs [--recompute].

Transmission error, greatest root stress and mesh stiffness of 20/31 and 20/-60 pairs of module 4 mm from 0 to 30
degrees of helix, faces of 15, 30 and 90 mm, on thin rims (four and a half modules) and thick bodies. The torque is
400 N m for every 30 mm of face. Finite elements take some minutes a pair, so their results are kept in
`validation/data/helical_pairs.json`; the core is computed afresh. Nothing is fitted on either side.

Root stress is taken alike on both sides: the stress on the surface of the loaded side's fillet, normal to the tooth's
trace, from three tenths of the fillet's length on (`ROOT_FROM`) and over the whole face, both ends included; the
greatest over all loaded teeth and mesh positions.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict, dataclass, replace
from math import atan, cos, radians, tan
from pathlib import Path

import numpy as np

import semiwear as sw
from fem_reference.fem_results import result_groups
from fem_reference.loaded import mesh_and_solve, torque_of
from fem_reference.mesh_position import MeshSettings
from fem_reference.pairs import pair_motion
from fem_reference.rigid_lines import RigidFlank
from fem_reference.root_load import BODIES, RootStress
from semiwear.errors import ResultFileError

DATA = Path(__file__).parent / "data" / "helical_pairs.json"
THIN, THICK = "thin", "thick"
_BORE = 11.2  # mm, radius of the bore of thick gears
_FOUR, _TWO = (0.0, 0.25, 0.5, 0.75), (0.0, 0.5)


@dataclass(frozen=True)
class HelicalPair:
    """A pair to be compared.

    Attributes
    ----------
    helix_angle : float [deg]
    face_width : float [mm]
    bodies : str
        ``"thin"`` or ``"thick"``.
    gear_teeth : int
        Negative inside.
    positions : tuple of float
        Mesh positions.
    """

    helix_angle: float
    face_width: float
    bodies: str
    gear_teeth: int = 31
    positions: tuple[float, ...] = _TWO

    @property
    def name(self) -> str:
        """Such as ``b30_helix20_thin``."""
        inside = "_internal" if self.gear_teeth < 0 else ""
        return f"b{self.face_width:g}_helix{self.helix_angle:g}_{self.bodies}{inside}"

    @property
    def scene(self) -> sw.Scene:
        """Its scene."""
        return helical_scene(self.helix_angle, self.face_width, self.bodies, self.gear_teeth)


PAIRS = (
    HelicalPair(30, 30, THICK, positions=_FOUR),
    HelicalPair(30, 30, THIN, positions=_FOUR),
    HelicalPair(20, 30, THIN),
    HelicalPair(0, 30, THIN, positions=_FOUR),
    HelicalPair(30, 15, THICK),
    HelicalPair(30, 90, THIN, positions=(0.0,)),
    HelicalPair(20, 30, THIN, -60),
    HelicalPair(0, 30, THICK),
    HelicalPair(20, 30, THICK),
    HelicalPair(15, 30, THIN),
    HelicalPair(8, 30, THIN),
    HelicalPair(8, 30, THICK),
    HelicalPair(15, 30, THICK),
    HelicalPair(20, 15, THICK),
    HelicalPair(15, 15, THIN),
    HelicalPair(20, 90, THIN, positions=(0.0,)),
    HelicalPair(30, 15, THIN),
    HelicalPair(0, 15, THICK),
    HelicalPair(0, 90, THIN, positions=(0.0,)),
    HelicalPair(30, 90, THICK, positions=(0.0,)),
)
"""The most telling first."""


def helical_scene(helix_angle: float, face_width: float, bodies: str, gear_teeth: int = 31) -> sw.Scene:
    """20 teeth on `gear_teeth`, normal module 4 mm; thick bodies are solid down to bores of 15 and 11.2 mm radius.

    Thin ones have bores of 0.63 and rims of 0.37 times the reference radius, less a root, in whole millimetres.
    """
    changes: dict[str, object] = {
        "gear_pair.pinion_teeth": 20,
        "gear_pair.gear_teeth": gear_teeth,
        "gear_pair.normal_module_mm": 4.0,
        "gear_pair.helix_angle_deg": float(helix_angle),
        "gear_pair.centre_distance_mm": None,
        "gear_pair.pinion_profile_shift": 0.2,
        "gear_pair.gear_profile_shift": -0.1 if gear_teeth > 0 else 0.0,
        "gear_pair.pinion_face_width_mm": float(face_width),
        "operation.pinion_torque_Nm": 400.0 / 30.0 * face_width,
    }
    edges = ("pinion_tip", "gear_tip", "pinion_end", "gear_end")
    changes |= {f"gear_pair.{edge}_edge_radius_mm": 0.2 for edge in edges}
    # said outright, so that the stored results stay those of their scenes
    pitch, inside = 2.0 / cos(radians(helix_angle)), gear_teeth < 0
    if bodies == THICK:
        bore, rim = 15.0, 40.0 if inside else round(31 * pitch - 0.1 * 4.0 - 5.0 - _BORE, 1)
    else:
        bore, rim = round(12.6 * pitch), 18.0 if inside else round(11.47 * pitch - 5.4)
    changes |= {"gear_pair.pinion_bore_radius_mm": float(bore), "gear_pair.gear_rim_thickness_mm": float(rim)}
    return sw.load_scene("spur_fzg_c").replace(changes)


@dataclass(frozen=True)
class HelicalResult:
    """What either side finds.

    Attributes
    ----------
    transmission_error : list of float [arcsec]
        Loaded, on the gear's side, at each mesh position.
    root_stress : dict from body to float [MPa]
        Greatest over positions and teeth.
    load_share : list of float
        Of the busiest pair at each mesh position.
    """

    transmission_error: list[float]
    root_stress: dict[str, float]
    load_share: list[float]


def finite_elements(
    pair: HelicalPair, elements_per_half_width: float = 1.5, root_elements: float | None = None
) -> HelicalResult:
    """Every tooth of both bodies; twelve elements over the face and more.

    Three elements to a half-width instead of one and a half change the transmission error by 0.05 % (30 degrees,
    thick). Root stress on elements of half a module along the face, a whole one on 90 mm.
    """
    scene = pair.scene
    flank = RigidFlank(pair_motion(scene))
    length = pair.face_width / 12.0 if pair.face_width <= 30 else 5.0
    settings = MeshSettings(elements_per_half_width, length, gear_teeth=None, pinion_teeth=None)
    usual = 0.5 if pair.face_width <= 30 else 1.0
    roots = RootStress(scene, None, None, face_size=usual if root_elements is None else root_elements)
    errors, shares, stress = [], [], dict.fromkeys(BODIES, 0.0)
    for position in pair.positions:
        _, result = mesh_and_solve(flank, position, settings, torque_of(flank), roots)
        groups, _ = result_groups([(flank, [result])], np.array([position]))
        errors.append(float(groups["mesh_cycle"]["transmission_error_loaded"][0][0]))
        loads = [found.contact.load for found in result.pairs.values()]
        shares.append(max(loads) / sum(loads))
        for (name, _), value in result.root_stress.items():
            stress[name] = max(stress[name], value)
    return HelicalResult(errors, stress, shares)


def core_result(pair: HelicalPair, fidelity: str = "line", **numerics: int) -> HelicalResult:
    """The same of the core, with `numerics` as in the scene; solids have free ends, so it is given them."""
    changes = {f"numerics.{name}": value for name, value in numerics.items()}
    scene = pair.scene.replace({"numerics.fidelity": fidelity, "effects.free_edges": {}, **changes})
    tree = sw.loaded_contact(scene, pair.positions)
    engagement = tree["engagement"].to_dataset().isel(wear_step=0)
    cycle = tree["mesh_cycle"].to_dataset().isel(wear_step=0)
    at = np.mod(engagement.roll_position.values + 1e-9, 1.0)
    shares = [float(engagement.load_share.values[np.abs(at - m) < 1e-6].max()) for m in pair.positions]
    return HelicalResult(
        [float(cycle.transmission_error_loaded.sel(mesh_position=m, method="nearest")) for m in pair.positions],
        {name: float(engagement.root_stress.sel(body=name).max()) for name in BODIES},
        shares,
    )


def mesh_stiffness(pair: HelicalPair, result: HelicalResult) -> float:
    """Force over deflection along the transverse line of action, for a millimetre of face [N/(mm um)].

    Mean of the mesh positions 0 and 1/2, which are computed of all pairs but the widest; of those, 0 alone. Source:
    ISO 6336-1:2019, 9 (c_gamma), here with the deflection at the load itself.
    """
    beta, alpha = radians(pair.helix_angle), radians(20.0)
    # transverse base radius for each tooth
    base = 2.0 / cos(beta) * cos(atan(tan(alpha) / cos(beta)))
    both = [error for at, error in zip(pair.positions, result.transmission_error, strict=True) if at in _TWO]
    moved = 1e3 * abs(pair.gear_teeth) * base * radians(abs(float(np.mean(both))) / 3600.0)
    torque = 1e3 * pair.scene.operation.pinion_torque_Nm
    return torque / (20.0 * base) / moved / pair.face_width


# --- the store ---------------------------------------------------------------------------------------------


def read() -> dict[str, HelicalResult]:
    """Stored results of finite elements by name of the pair.

    Raises
    ------
    ResultFileError
        If a stored scene is not the one that would be computed now.
    """
    found = {}
    known = {pair.name: pair for pair in PAIRS}
    for name, entry in json.loads(DATA.read_text(encoding="utf-8")).items():
        pair = known.get(name)
        if pair is None or entry["scene_toml"] != pair.scene.to_toml() or entry["positions"] != list(pair.positions):
            raise ResultFileError(
                f"{DATA}: {name} was computed for another scene; run python -m validation.helical_pairs "
                f"--recompute {name}"
            )
        found[name] = HelicalResult(**entry["finite_elements"])
    return found


def store(pair: HelicalPair, result: HelicalResult) -> None:
    """Keep a result of finite elements, seven digits of it."""
    kept = json.loads(DATA.read_text(encoding="utf-8")) if DATA.is_file() else {}

    def short(value: object) -> object:
        if isinstance(value, dict):
            return {key: short(one) for key, one in value.items()}
        return [float(f"{one:.7g}") for one in value] if isinstance(value, list) else float(f"{value:.7g}")

    kept[pair.name] = {
        "positions": list(pair.positions),
        "finite_elements": short(asdict(result)),
        "scene_toml": pair.scene.to_toml(),
    }
    fresh = DATA.with_suffix(".part")
    fresh.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    fresh.replace(DATA)


def table() -> str:
    """Core over finite elements of every stored pair, and the mesh stiffness relative to the spur pair's."""
    stored, both_sides = read(), {}
    lines = [
        f"{'pair':28s} {'TE core':>9s} {'TE FE':>9s} {'ratio':>6s}   "
        f"{'root pinion core, FE, ratio':>28s}   {'root gear core, FE, ratio':>28s}"
    ]
    for pair in PAIRS:
        if (judge := stored.get(pair.name)) is None:
            continue
        core = core_result(pair)
        both_sides[pair] = core, judge
        mean = [float(np.mean(one.transmission_error)) for one in (core, judge)]
        row = f"{pair.name:28s} {mean[0]:9.2f} {mean[1]:9.2f} {mean[0] / mean[1]:6.3f}"
        for name in BODIES:
            both = core.root_stress[name], judge.root_stress[name]
            row += f"   {both[0]:10.1f} {both[1]:10.1f} {both[0] / both[1]:6.3f}"
        lines.append(row)
    lines += ["", f"{'mesh stiffness, N/(mm um)':28s} {'core':>9s} {'FE':>9s}   over spur: core, FE, ratio"]
    for pair, found in both_sides.items():
        spur = next((one for one in both_sides if _spur_of(one, pair)), None)
        if spur is None:
            continue
        stiffness = [mesh_stiffness(pair, one) for one in found]
        trend = [c / mesh_stiffness(spur, one) for c, one in zip(stiffness, both_sides[spur], strict=True)]
        lines.append(
            f"{pair.name:28s} {stiffness[0]:9.3f} {stiffness[1]:9.3f}   "
            f"{trend[0]:.3f} {trend[1]:.3f} {trend[0] / trend[1]:.3f}"
        )
    return "\n".join(lines)


def _spur_of(spur: HelicalPair, pair: HelicalPair) -> bool:
    """Whether one pair is the other without a helix angle."""
    return spur == replace(pair, helix_angle=0, positions=spur.positions)


def main() -> None:
    """Print the comparison; compute finite elements anew where that is asked for."""
    names = [pair.name for pair in PAIRS]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recompute", nargs="*", choices=names, help="finite elements anew; alone: all pairs")
    chosen = parser.parse_args().recompute
    for pair in PAIRS:
        if chosen is not None and (not chosen or pair.name in chosen):
            store(pair, finite_elements(pair))
            print(f"{pair.name}: {DATA}", flush=True)
    print(table())


if __name__ == "__main__":
    main()
