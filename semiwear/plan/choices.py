"""Choice for each slot of the physics, and its reason: the rows of a plan's table."""

from __future__ import annotations

from dataclasses import dataclass

from semiwear.meshing.point_flanks import surfaces_summary
from semiwear.scene import CylindricalPair, FlankPointsPair, Scene
from semiwear.scene.rules import USUAL_WEAR_COEFFICIENTS
from semiwear.scene.tables import RESOLUTION, Wear


@dataclass(frozen=True)
class Choice:
    """Decision for one slot."""

    slot: str
    chosen: str
    runs: bool
    why: str
    references: tuple[str, ...] = ()


def kernels_of(scene: Scene, wears: bool | None = None) -> str:
    """Kind of run in the list of kernels: `contact`, `line`, `both` (lines, and both flanks wear) or `patch`.

    `wears` says whether wear is computed; None: if the scene has a table [wear].
    """
    if scene.numerics.fidelity == "patch":
        return "patch"
    if not (scene.wear is not None if wears is None else wears):
        return "contact"
    return "both" if scene.wear is not None and len(scene.wear.worn_bodies) > 1 else "line"


def physics_choices(scene: Scene) -> tuple[Choice, ...]:
    """Choices for all slots, in the order of the data flow."""
    slots = (
        _geometry_choice,
        _contact_choice,
        _compliance_choice,
        _root_stress_choice,
        _pairs_choice,
        _wear_choice,
        _mapping_choice,
        _scheme_choice,
        _end_choice,
    )
    found = tuple(slot(scene) for slot in slots)
    return found if scene.numerics.accuracy is None else (*found, _accuracy_choice(scene))


def _geometry_choice(scene: Scene) -> Choice:
    pair = scene.gear_pair
    note = f": {surfaces_summary(pair)}" if isinstance(pair, FlankPointsPair) else ""
    if isinstance(pair, CylindricalPair) and pair.helix_in_radians:
        note = f"; unusual: {pair.helix_in_radians}"
    return Choice("geometry", pair.description, True, f'gear_pair.type = "{pair.type}"{note}', pair.references)


def _contact_choice(scene: Scene) -> Choice:
    numerics = scene.numerics
    if numerics.fidelity == "patch":
        return Choice(
            "contact",
            "pressure patches on the half-space",
            True,
            f'numerics.fidelity = "patch", {numerics.face_slices} slices, '
            f"{numerics.cells_per_half_width} cells to a half-width",
            (
                "Love 1929, Phil. Trans. R. Soc. A 228",
                "Liu, Wang, Liu 2000, Wear 243",
                "Polonsky, Keer 1999, Wear 231",
                "Park, Kolivand, Kahraman 2012, Mech. Mach. Theory 52",
            ),
        )
    return Choice(
        "contact",
        "line loads, Hertz across them",
        True,
        f'numerics.fidelity = "line", {numerics.face_slices} slices',
        ("Johnson 1985, Contact Mechanics, ch. 4", "Park, Kolivand, Kahraman 2014, Mech. Mach. Theory"),
    )


def _compliance_choice(scene: Scene) -> Choice:
    if scene.numerics.tooth_compliance == "rigid":
        return Choice("tooth compliance", "rigid", False, 'numerics.tooth_compliance = "rigid"')
    if scene.numerics.tooth_compliance != "prism":
        why = f'numerics.tooth_compliance = "{scene.numerics.tooth_compliance}"'
        return Choice("tooth compliance", "influence data", True, why)
    return Choice(
        "tooth compliance",
        f"finite prisms, {scene.numerics.harmonics} harmonics",
        True,
        'numerics.tooth_compliance = "prism": teeth, neighbours and rims of both bodies',
        ("Cheung 1976, Finite Strip Method in Structural Analysis", "Weber and Banaschek 1953"),
    )


def _root_stress_choice(scene: Scene) -> Choice:
    runs = scene.numerics.tooth_compliance != "rigid"
    why = "comes with the tooth compliance" if runs else "needs numerics.tooth_compliance other than rigid"
    return Choice("root stress", "tangential, greatest along the root" if runs else "none", runs, why)


def _pairs_choice(scene: Scene) -> Choice:
    pairs = scene.numerics.tooth_pairs
    if pairs == "auto":
        return Choice("load sharing", "all tooth pairs", True, 'numerics.tooth_pairs = "auto": whatever can touch')
    return Choice("load sharing", f"{pairs} tooth pair(s)", pairs != 1, f"numerics.tooth_pairs = {pairs}")


def _wear_choice(scene: Scene) -> Choice:
    if scene.wear is None:
        return Choice("wear", "none", False, "the scene has no table [wear]")
    bodies = scene.wear.worn_bodies
    k = ", ".join(f"{scene.wear.coefficient(body):g}" for body in bodies)
    default = f' (a default, as gear_pair.type = "{scene.gear_pair.type}")' if scene.wear._derived else ""
    return Choice(
        "wear",
        f"Archard, k = {k} mm^2/N",
        True,
        f"[wear], worn_bodies = {', '.join(bodies)}{default}{_unusual(scene.wear)}",
        ("Archard 1953, J. Appl. Phys. 24", "Andersson and Eriksson 1990, KTH"),
    )


def _unusual(wear: Wear) -> str:
    """Note on wear coefficients outside the usual range; empty if there are none."""
    low, high = USUAL_WEAR_COEFFICIENTS
    outside = [f"{k:g}" for body in wear.worn_bodies if not low <= (k := wear.coefficient(body)) <= high]
    note = f"; unusual: {', '.join(outside)} is outside {low:g} to {high:g} mm^2/N, is it in another unit?"
    return note if outside else ""


def _mapping_choice(scene: Scene) -> Choice:
    numerics = scene.numerics
    if scene.wear is None:
        return Choice("wear mapping", "none", False, "no wear")
    marched = numerics.wear_mapping == "marched"
    return Choice(
        "wear mapping",
        "marched: pressures summed at the nodes" if marched else "interpolated between roll positions, cusp kept",
        True,
        f'numerics.wear_mapping = "{numerics.wear_mapping}", {numerics.roll_positions} roll positions',
    )


def _scheme_choice(scene: Scene) -> Choice:
    if scene.wear is None:
        return Choice("wear steps", "none", False, "no wear")
    scheme = scene.numerics.wear_scheme
    if scheme != "explicit" and "wear_steps" in scene.numerics.chosen_for_accuracy:
        why = "numerics.accuracy: in two stages, as long as their error allows"
        return Choice("wear steps", "adaptive, implicit: stable at any step", True, why)
    how = {
        "implicit": "implicit: stable at any step",
        "two-stage": "implicit, in two stages: stable at any step",
        "explicit": "explicit: under the loads at the start of a step",
    }
    return Choice("wear steps", how[scheme], True, f'numerics.wear_scheme = "{scheme}"')


def parts_deep_steps(scene: Scene) -> bool:
    """Whether deep steps to control depths are divided; explicit and adaptive steps are not."""
    return scene.numerics.wear_scheme != "explicit" and "wear_steps" not in scene.numerics.chosen_for_accuracy


def _end_choice(scene: Scene) -> Choice:
    if scene.wear is None:
        return Choice("end of the run", "none", False, "no wear")
    until = scene.wear.until
    if (depths := until.control_depths_um) is not None:
        end = f"{len(depths)} control depths to {depths[-1]:g} um"
        why = f"wear.until.control_depths_um on the {scene.wear.watched_body}: meshes found for each"
        if parts_deep_steps(scene):
            why += "; deep steps in parts"
        return Choice("end of the run", end, True, why)
    end = f"{until.meshes:g} meshes, steps: {scene.numerics.wear_steps}"
    if until.hours is None:
        return Choice("end of the run", end, True, "wear.until.meshes")
    speed = f"{scene.operation.pinion_speed_rpm:g} rpm of the pinion"
    return Choice("end of the run", f"{until.hours:g} h: {end}", True, f"wear.until.hours at {speed}")


def _accuracy_choice(scene: Scene) -> Choice:
    numerics = scene.numerics
    open_fields = numerics.chosen_for_accuracy
    given = [f"{name} = {getattr(numerics, name)}" for name in RESOLUTION if name not in open_fields]
    why = f"numerics.accuracy = {numerics.accuracy:g}"
    if open_fields:
        why += f"; chosen by coarse runs: {', '.join(open_fields)}"
    if given:
        why += f"; kept: {', '.join(given)}"
    references = (
        "Richardson 1911, Phil. Trans. R. Soc. A 210",
        "Hairer, Norsett, Wanner 1993, Solving Ordinary Differential Equations I",
    )
    return Choice("accuracy", f"{numerics.accuracy:g} of the greatest of a kind", True, why, references)
