"""From a scene's tables to the physics that will run, and why; nothing else decides it.

One function a slot: each looks at the scene, says what it chose, and is able to build it. What is not chosen is
not constructed.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from semiwear.compliance.blas_threads import one_blas_thread
from semiwear.compliance.influence import InfluenceOnLines, body_influence, read_influence
from semiwear.compliance.prism import PrismSection, prism_section
from semiwear.compliance.tooth import BodyOnLines, CompliantBody, LinePlaces, ToothBody
from semiwear.contact.hertz import effective_modulus, elliptic_contact, line_contact_half_width
from semiwear.contact.line_contact import LineContact, usual_approach
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.contact.patch_contact import PatchContact
from semiwear.contact.patch_gap import PatchCells
from semiwear.contact.teeth_solver import TeethSolver
from semiwear.meshing.contact_lines import ContactLines, face_stations, trace_contact_lines
from semiwear.meshing.face_gear_pair import FaceGearMesh
from semiwear.meshing.flank_grid import flank_grid
from semiwear.meshing.flank_pair import BODIES, DRIVING, FlankPair
from semiwear.meshing.roll_grid import RollGrid, even_roll_grid, given_roll_grid, pairs_that_can_touch
from semiwear.meshing.tooth_contact import contact_points
from semiwear.scene import FaceGearPair, Material, Numerics, Placement, Scene
from semiwear.wear.mapping import Doses, InterpolatedWear, MarchedWear, WearMapping
from semiwear.wear.stepping import ControlPoint, WearStepper

__all__ = ["Choice", "Plan", "plan", "prisms"]

_FINE_ROLLS = 96  # roll positions to a mesh cycle on which wear is summed, at least
_REACH = 4.0  # usual approaches that a slice may be apart and still count, besides the wear to come
_WEAR_TO_COME = 0.15  # mm


@dataclass(frozen=True)
class Choice:
    """What was decided for one slot.

    Attributes
    ----------
    slot, chosen : str
    runs : bool
    why : str
    references : tuple of str
    """

    slot: str
    chosen: str
    runs: bool
    why: str
    references: tuple[str, ...] = ()


@dataclass(frozen=True)
class Plan:
    """The physics of a scene: printed as a table, built on demand.

    Attributes
    ----------
    scene : Scene
    choices : tuple of Choice
    """

    scene: Scene
    choices: tuple[Choice, ...]

    def __str__(self) -> str:
        head = ("physics", "runs", "chosen", "why")
        rows = [(c.slot, "yes" if c.runs else "no", c.chosen, c.why) for c in self.choices]
        wide = [max(len(row[k]) for row in [head, *rows]) for k in range(3)]
        return "\n".join(_wrapped((head, ("-" * wide[0], "-" * wide[1], "-" * wide[2], "---"), *rows), wide))

    @property
    def references(self) -> tuple[str, ...]:
        """Published sources of the physics that runs."""
        found = [source for choice in self.choices if choice.runs for source in choice.references]
        return tuple(dict.fromkeys(found))

    def flank_pair(self, placement: Placement | None = None) -> FlankPair:
        """The two flanks in mesh."""
        return FaceGearMesh(self.scene.gear_pair, _on_loaded_flank(self.scene, placement))

    @one_blas_thread()
    def loaded_teeth(
        self, placement: Placement | None = None, roll_positions: np.ndarray | None = None
    ) -> LoadedTeeth:
        """The loaded contact of all tooth pairs."""
        scene, numerics = self.scene, self.scene.numerics
        pair = self.flank_pair(placement)
        modulus = effective_modulus(*_elastic(scene.material.pinion), *_elastic(scene.material.gear))
        torque = 1e3 * scene.operation.pinion_torque_Nm
        low, high = pair.face_limits
        middle = contact_points(self.flank_pair(), np.zeros(1))
        lever = float(pair.lever_arm(middle.position)[0])
        along, across = np.maximum(middle.curvature[0], 1e-9)
        usual = torque / lever / (0.5 * (high - low))
        reach = _REACH * usual_approach(usual, modulus) + _WEAR_TO_COME
        rolls = _roll_grid(scene, pair, reach, roll_positions)
        fine = trace_contact_lines(pair, rolls.fine_roll, face_stations(pair, numerics.face_slices))
        lines = fine.every(rolls.substeps)
        grid = flank_grid(pair, fine.face, numerics.profile_points)
        line = LineContact(
            lines=lines,
            per_cycle=rolls.phase.size,
            bodies=_tooth_compliance(scene, pair, lines),
            grid=grid,
            torque=np.full(rolls.phase.size, torque),
            reach=reach,
            modulus=modulus,
            usual_load=usual,
            usual_half_width=float(line_contact_half_width(np.array(usual), np.array(across), modulus)),
            max_iterations=numerics.max_iterations,
        )
        whole = elliptic_contact(torque / lever, float(along), float(across), modulus)
        return LoadedTeeth(
            pair=pair,
            rolls=rolls,
            fine=fine,
            lines=lines,
            grid=grid,
            solver=_solver(line, numerics, whole.minor_half_axis),
            half_width=whole.minor_half_axis,
            zero=_unworn_zero(pair, lines if roll_positions is None else None, rolls, numerics),
        )

    def wear_stepper(self, teeth: LoadedTeeth) -> WearStepper:
        """The wear of the driven flank; the scene must have a table [wear]."""
        wear = self.scene.wear
        assert wear is not None
        numerics = self.scene.numerics
        mapping: WearMapping = InterpolatedWear()
        if numerics.wear_mapping == "marched":
            mapping = MarchedWear()
        coefficients = Doses(wear.coefficient_mm2_per_N)
        return WearStepper(teeth, coefficients, numerics.wear_scheme == "implicit", mapping)

    def control_point(self, teeth: LoadedTeeth) -> ControlPoint | None:
        """The control point on the driven flank, if the scene names one."""
        point = self.scene.wear.control_point if self.scene.wear else None
        if point is None:
            return None
        face = teeth.grid.face
        profile = teeth.pair.profile_at(face, np.full(face.size, point.height_mm))
        return ControlPoint(point.radius_mm, profile)


def plan(scene: Scene) -> Plan:
    """What will run for a scene, what will not, and why."""
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
        _effects_choice,
    )
    return Plan(scene, tuple(slot(scene) for slot in slots))


def _geometry_choice(scene: Scene) -> Choice:
    pair = scene.gear_pair
    return Choice(
        "geometry",
        f"face gear {pair.pinion_teeth}/{pair.gear_teeth}, shaper {pair.shaper_teeth}",
        True,
        'gear_pair.type = "face_gear"',
        ("Litvin and Fuentes 2004, Gear Geometry and Applied Theory, ch. 18",),
    )


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
                "Hintermueller, Ito, Kunisch 2002, SIAM J. Optim. 13",
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
    bodies = ", ".join(scene.wear.worn_bodies)
    return Choice(
        "wear",
        f"Archard, k = {scene.wear.coefficient_mm2_per_N:g} mm^2/N",
        True,
        f"[wear], worn_bodies = {bodies}",
        ("Archard 1953, J. Appl. Phys. 24", "Andersson and Eriksson 1990, KTH"),
    )


def _mapping_choice(scene: Scene) -> Choice:
    numerics = scene.numerics
    if scene.wear is None:
        return Choice("wear mapping", "none", False, "no wear")
    marched = numerics.wear_mapping == "marched"
    return Choice(
        "wear mapping",
        "marched: summed where it happens" if marched else "interpolated between roll positions, cusp kept",
        True,
        f'numerics.wear_mapping = "{numerics.wear_mapping}", {numerics.roll_positions} roll positions',
    )


def _scheme_choice(scene: Scene) -> Choice:
    if scene.wear is None:
        return Choice("wear steps", "none", False, "no wear")
    implicit = scene.numerics.wear_scheme == "implicit"
    return Choice(
        "wear steps",
        "implicit: stable at any step" if implicit else "explicit: loads of the start hold",
        True,
        f'numerics.wear_scheme = "{scene.numerics.wear_scheme}"',
    )


def _end_choice(scene: Scene) -> Choice:
    if scene.wear is None:
        return Choice("end of the run", "none", False, "no wear")
    until = scene.wear.until
    if until.control_depths_um is not None:
        depths = until.control_depths_um
        return Choice(
            "end of the run",
            f"{len(depths)} control depths to {depths[-1]:g} um",
            True,
            "wear.until.control_depths_um: meshes found for each",
        )
    return Choice(
        "end of the run",
        f"{until.meshes:g} meshes, steps: {scene.numerics.wear_steps}",
        True,
        "wear.until.meshes",
    )


def _effects_choice(scene: Scene) -> Choice:
    return Choice("effects", "none", False, "no [effects.*] table: friction, heat, misalignment are not constructed")


def _on_loaded_flank(scene: Scene, placement: Placement | None) -> Placement:
    """The coast flank is the drive flank in a mirror at x = 0: what turns the placement is mirrored instead."""
    placement = placement or Placement()
    if scene.operation.loaded_flank == "drive":
        return placement
    return Placement(
        offset_mm=-placement.offset_mm,
        axial_pinion_mm=placement.axial_pinion_mm,
        axial_gear_mm=placement.axial_gear_mm,
        shaft_angle_error_mrad=placement.shaft_angle_error_mrad,
        pinion_slope_mrad=-placement.pinion_slope_mrad,
    )


def _elastic(material: Material) -> tuple[float, float]:
    return material.youngs_modulus_MPa, material.poissons_ratio


def _roll_grid(scene: Scene, pair: FlankPair, reach: float, roll_positions: np.ndarray | None) -> RollGrid:
    wanted = scene.numerics.tooth_pairs
    if wanted == "auto":
        start, pairs = pairs_that_can_touch(pair, reach)
    else:
        # the pairs nearest to the pitch point
        start, pairs = -0.5 * int(wanted), int(wanted)
    if roll_positions is not None:
        return given_roll_grid(start, pairs, roll_positions)
    return even_roll_grid(start, pairs, scene.numerics.roll_positions, _FINE_ROLLS)


def _solver(line: LineContact, numerics: Numerics, half_width: float) -> TeethSolver:
    if numerics.fidelity == "line":
        return line
    return PatchContact(line, PatchCells(line.lines, line.grid, half_width / numerics.cells_per_half_width))


def _unworn_zero(pair: FlankPair, lines: ContactLines | None, rolls: RollGrid, numerics: Numerics) -> float:
    """Mean of the least separation over an even mesh cycle, whose lines are traced unless they are given [mm]."""
    if lines is None:
        even = even_roll_grid(rolls.start, rolls.pairs, numerics.roll_positions, numerics.roll_positions)
        lines = trace_contact_lines(pair, even.roll, face_stations(pair, numerics.face_slices))
    least = lines.separation[0].min(axis=1).reshape(rolls.pairs, -1).min(axis=0)
    return float(least.mean())


def _tooth_compliance(scene: Scene, pair: FlankPair, lines: ContactLines) -> tuple[CompliantBody, ...]:
    if scene.numerics.tooth_compliance == "rigid":
        return ()
    if scene.numerics.tooth_compliance != "prism":
        return _influence(scene, pair, lines)
    bodies = []
    for index, material in enumerate((scene.material.pinion, scene.material.gear)):
        matrices = prisms(scene.gear_pair, index, material, scene.numerics.harmonics)
        shape = pair.prism_body(index)
        body = ToothBody(
            start=shape.start,
            width=shape.width,
            faces=np.array(shape.faces),
            sections=matrices,
            ahead=1 if index == DRIVING else -1,
            youngs_modulus=material.youngs_modulus_MPa,
            poissons_ratio=material.poissons_ratio,
        )
        bodies.append(BodyOnLines.of(body, _places(lines, index)))
    return tuple(bodies)


def _influence(scene: Scene, pair: FlankPair, lines: ContactLines) -> tuple[CompliantBody, ...]:
    data = read_influence(scene.numerics.tooth_compliance)
    borders = pair.borders(lines.face, sharp=True)
    ends = ((borders.partner_root, borders.partner_tip), (borders.root, borders.tip))
    bodies = []
    for index, material in enumerate((scene.material.pinion, scene.material.gear)):
        shape = pair.prism_body(index)
        body = body_influence(
            data, index, (shape.start, shape.start + shape.width), 1 if index == DRIVING else -1, *_elastic(material)
        )
        root, tip = (np.broadcast_to(end, lines.profile.shape) for end in ends[index])
        bodies.append(InfluenceOnLines.of(body, _places(lines, index), root, tip))
    return tuple(bodies)


def _places(lines: ContactLines, body: int) -> LinePlaces:
    if body == DRIVING:
        return LinePlaces(lines.partner_profile, lines.partner_slope, lines.partner_face)
    shape = lines.profile.shape
    return LinePlaces(lines.profile, np.ones(shape), np.broadcast_to(lines.face, shape))


@lru_cache(maxsize=16)
def prisms(table: FaceGearPair, body: int, material: Material, harmonics: int) -> tuple[PrismSection, ...]:
    """Prism matrices of a body; they depend on geometry and material alone and are kept between runs."""
    shape = FaceGearMesh(table, Placement()).prism_body(body)
    return tuple(
        prism_section(
            section,
            width=shape.width,
            youngs_modulus=material.youngs_modulus_MPa,
            poissons_ratio=material.poissons_ratio,
            harmonics=harmonics,
            name=f"{BODIES[body]} section at {face:.4g} mm",
        )
        for face, section in zip(shape.faces, shape.sections, strict=True)
    )


def _wrapped(rows: Iterable[tuple[str, ...]], wide: list[int], columns: int = 118) -> Iterable[str]:
    """Rows of a table whose last column is folded."""
    indent = sum(wide) + 2 * len(wide)
    for row in rows:
        left = "  ".join(text.ljust(width) for text, width in zip(row[:-1], wide, strict=True))
        lines = textwrap.wrap(row[-1], max(columns - indent, 24)) or [""]
        yield f"{left}  {lines[0]}"
        for line in lines[1:]:
            yield " " * indent + line
