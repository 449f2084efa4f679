"""Tooth compliance of both bodies of a scene, by `numerics.tooth_compliance`."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.compliance.beyond_prism import BeyondOnLines, WheelInfluence, wheel_influence
from semiwear.compliance.elastic_teeth import CompliantBody, ElasticTeeth, PointCompliance
from semiwear.compliance.influence import InfluenceOnLines, body_influence, read_influence
from semiwear.compliance.prism import PrismSection, prism_section
from semiwear.compliance.root import ROOT_FROM, ROOT_POINTS
from semiwear.compliance.taper import tapered
from semiwear.compliance.tooth import BodyOnLines, LinePlaces, OfModulus, ToothBody
from semiwear.compliance.tooth_ends import EndEffect, end_effect
from semiwear.geometry.section import RackRim
from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_pair import BODIES, DRIVING, FlankPair, PrismBody
from semiwear.meshing.pairs import flank_pair, on_loaded_flank
from semiwear.plan.compared import Compared, Course, Toothing
from semiwear.plan.straight import UnlikeError, on_line
from semiwear.scene import GearPair, Material, Placement, Scene
from semiwear.threads import in_threads

_TAPERING = 4
"""Least number of sections with which a tooth counts as tapered."""


class Elastic(NamedTuple):
    """Elastic constants of a body.

    Attributes
    ----------
    youngs_modulus : float [MPa]
    poissons_ratio : float
    """

    youngs_modulus: float
    poissons_ratio: float


def elastic(material: Material) -> Elastic:
    """Elastic constants of a material."""
    return Elastic(material.youngs_modulus_MPa, material.poissons_ratio)


def tooth_compliance(
    scene: Scene, pair: FlankPair, lines: ContactLines, compared: Compared | None = None, *, recurs: bool = True
) -> ElasticTeeth:
    """Compliant bodies on contact lines; none for rigid teeth.

    Lines that recur find the same object, others what is known of the compliance at their roll positions. Runs that
    are compared with one another share their prisms: these are found for common Young's moduli, with scaled
    deflections, and interpolated along the course of the changed field.
    """
    numerics = scene.numerics
    if numerics.tooth_compliance == "rigid":
        return ElasticTeeth(lines.roll, tuple)
    if numerics.tooth_compliance != "prism":
        return ElasticTeeth(lines.roll, partial(_influence, scene, pair, lines))
    own = _Prismatic(Toothing.of(scene), scene.operation.loaded_flank, pair, numerics.harmonics, compared)
    if recurs:
        return _prisms_on_lines(own, lines)
    return ElasticTeeth(lines.roll, partial(_prism_bodies, own, lines), _known_compliance(own, lines.face.tobytes()))


class _Prismatic(NamedTuple):
    """All that prisms depend on but the lines on which they are loaded."""

    toothing: Toothing
    loaded_flank: str
    pair: FlankPair
    harmonics: int
    compared: Compared | None


@lru_cache(maxsize=4)
def _prisms_on_lines(own: _Prismatic, lines: ContactLines) -> ElasticTeeth:
    return ElasticTeeth(lines.roll, partial(_prism_bodies, own, lines))


@lru_cache(maxsize=4)
def _known_compliance(own: _Prismatic, face: bytes) -> dict[tuple[bytes, bytes], PointCompliance]:
    """A cache for `ElasticTeeth` on any lines at these stations."""
    return {}


def _prism_bodies(own: _Prismatic, lines: ContactLines) -> tuple[CompliantBody, ...]:
    toothing, loaded_flank, pair, harmonics, compared = own
    common = toothing if compared is None else toothing.at_moduli(compared.youngs_moduli)
    course = None if compared is None else compared.course
    bodies: list[CompliantBody] = []
    for index, material in enumerate(toothing.materials):
        places = _places(lines, index)
        parts = _parts_on(course, common, loaded_flank, index, harmonics)
        foot = None if parts.wheel is None else parts.wheel.foot
        radius = None if foot is None else pair.flank_place(index, places.face, places.profile)[1]
        # loads act on the prism in their section normal to an inclined tooth
        along = None if foot is None or radius is None else places.face + foot.prism_aside(radius)
        # the taper of a tooth contains its ends
        beyond = None if parts.ends is None else _beyond(parts, pair, index, places, radius)
        on_lines = BodyOnLines.of(parts.body, places, beyond, along)
        same = material == common.materials[index]
        bodies.append(on_lines if same else OfModulus(on_lines, material.youngs_modulus_MPa))
    return tuple(bodies)


@dataclass(frozen=True)
class _Parts:
    """Prisms, free ends and wheel of a body; no ends for tapered teeth, a wheel for inclined teeth only."""

    body: ToothBody
    ends: EndEffect | None
    wheel: WheelInfluence | None


def _parts(toothing: Toothing, loaded_flank: str, index: int, harmonics: int) -> _Parts:
    table, material = toothing.gears, toothing.materials[index]
    body = toothed(table, index, material, harmonics)
    if body.taper is not None:
        return _Parts(body, None, None)
    # the coast flank equals the drive flank of the opposite hand
    loaded, _ = on_loaded_flank(table, Placement(), loaded_flank)
    inclined = flank_pair(loaded, Placement()).prism_body(index).foot is not None
    wheel = wheel_under(loaded, index, material) if inclined else None
    return _Parts(body, free_ends(loaded, index, material, harmonics), wheel)


def _parts_on(course: Course | None, own: Toothing, loaded_flank: str, index: int, harmonics: int) -> _Parts:
    """Parts interpolated on a course; those of the gears themselves without one, or if its ends are not alike."""
    if course is not None:
        at, beside = (_parts(end, loaded_flank, index, harmonics) for end in (course.at, course.beside))
        with suppress(UnlikeError):
            return on_line(at, beside, course.share)
    return _parts(own, loaded_flank, index, harmonics)


def _beyond(
    parts: _Parts, pair: FlankPair, index: int, places: LinePlaces, radius: FloatArray | None
) -> BeyondOnLines:
    """Compliance beyond the prism of a tooth of one section, or of sections that are alike.

    `radius`: of the places [mm], for an inclined tooth.
    """
    shape, body = pair.prism_body(index), parts.body
    assert parts.ends is not None
    along, height = places.face - (shape.start + 0.5 * shape.width), body.heights(places)
    if parts.wheel is None or radius is None:
        return BeyondOnLines.of(parts.ends, shape.width, along, height)
    step = 1e-4 * float(np.ptp(body.sections[0].load_profile))
    _, farther = pair.flank_place(index, places.face, places.profile + step)
    heights = body.sections[0].load_profile
    _, at_heights = pair.flank_place(index, np.full(heights.shape, shape.start + 0.5 * shape.width), heights)
    return BeyondOnLines.of(
        parts.ends,
        shape.width,
        along,
        height,
        parts.wheel,
        (radius, (farther - radius) / step * places.slope, at_heights),
    )


def _influence(scene: Scene, pair: FlankPair, lines: ContactLines) -> tuple[CompliantBody, ...]:
    data = read_influence(scene.numerics.tooth_compliance)
    borders = pair.borders(lines.face, sharp=True)
    ends = ((borders.driving_root, borders.driving_tip), (borders.root, borders.tip))
    bodies = []
    for index, material in enumerate((scene.material.pinion, scene.material.gear)):
        shape = pair.prism_body(index)
        body = body_influence(
            data, index, (shape.start, shape.start + shape.width), 1 if index == DRIVING else -1, *elastic(material)
        )
        root, tip = (np.broadcast_to(end, lines.profile.shape) for end in ends[index])
        bodies.append(InfluenceOnLines.of(body, _places(lines, index), root, tip))
    return tuple(bodies)


def _places(lines: ContactLines, body: int) -> LinePlaces:
    if body == DRIVING:
        return LinePlaces(lines.driving_profile, lines.driving_slope, lines.driving_face)
    shape = lines.profile.shape
    return LinePlaces(lines.profile, np.ones(shape), np.broadcast_to(lines.face, shape))


@lru_cache(maxsize=16)
def prisms(table: GearPair, index: int, material: Material, harmonics: int) -> tuple[PrismSection, ...]:
    """The prisms of a body's sections, cached like `toothed`."""
    shape = flank_pair(table, Placement()).prism_body(index)
    youngs_modulus, poissons_ratio = elastic(material)

    def prism(section: int) -> PrismSection:
        return prism_section(
            shape.sections[section],
            width=shape.tooth_length,
            youngs_modulus=youngs_modulus,
            poissons_ratio=poissons_ratio,
            harmonics=harmonics,
            name=f"{BODIES[index]} section at {shape.faces[section]:.4g} mm",
        )

    found = tuple(in_threads(prism, range(len(shape.sections))))
    if shape.foot is None:
        return found
    # the prism has the length of the tooth on the reference cylinder
    crowding = shape.foot.crowding
    return tuple(
        replace(prism, deflection=crowding * prism.deflection, stress=crowding * prism.stress) for prism in found
    )


def _tapers(shape: PrismBody) -> bool:
    """Whether the section of a tooth on a rack changes along the tooth."""
    on_rack = len(shape.sections) >= _TAPERING and all(isinstance(s.rim, RackRim) for s in shape.sections)
    return on_rack and bool(np.isclose(shape.tooth_length, shape.width, rtol=1e-6))


@lru_cache(maxsize=16)
def toothed(table: GearPair, index: int, material: Material, harmonics: int) -> ToothBody:
    """Elastic teeth of a body, cached, since they depend on geometry and material alone.

    For a tooth on a rack whose section changes the prisms are corrected by `taper`; a tooth on a ring is interpolated
    between its sections.
    """
    shape = flank_pair(table, Placement()).prism_body(index)
    youngs_modulus, poissons_ratio = elastic(material)
    sections = prisms(table, index, material, harmonics)
    body = ToothBody(
        start=shape.start,
        width=shape.width,
        faces=np.array(shape.faces),
        sections=sections,
        ahead=1 if index == DRIVING else -1,
        youngs_modulus=youngs_modulus,
        poissons_ratio=poissons_ratio,
    )
    if not _tapers(shape):
        return body
    residual, taper = tapered(
        shape.sections,
        body.faces,
        sections,
        body.stations,
        np.linspace(ROOT_FROM, 1.0, ROOT_POINTS),
        start=shape.start,
        width=shape.width,
        youngs_modulus=youngs_modulus,
        poissons_ratio=poissons_ratio,
        name=f"{BODIES[index]} section",
    )
    return replace(body, sections=residual, taper=taper)


@lru_cache(maxsize=16)
def free_ends(table: GearPair, index: int, material: Material, harmonics: int) -> EndEffect:
    """Correction for the free ends of a body's teeth, from the middle section; cached like `toothed`."""
    shape = flank_pair(table, Placement()).prism_body(index)
    youngs_modulus, poissons_ratio = elastic(material)
    middle = len(shape.sections) // 2
    return end_effect(
        shape.sections[middle],
        prisms(table, index, material, harmonics)[middle],
        width=shape.tooth_length if shape.foot is None else shape.width,
        slant=0.0 if shape.foot is None else shape.foot.slant,
        youngs_modulus=youngs_modulus,
        poissons_ratio=poissons_ratio,
        name=f"{BODIES[index]} section",
    )


@lru_cache(maxsize=16)
def wheel_under(table: GearPair, index: int, material: Material) -> WheelInfluence:
    """The wheel under the helical teeth of a body, cached like `toothed`."""
    shape = flank_pair(table, Placement()).prism_body(index)
    assert shape.foot is not None
    youngs_modulus, poissons_ratio = elastic(material)
    section = shape.sections[len(shape.sections) // 2]
    return wheel_influence(shape.foot, section, youngs_modulus=youngs_modulus, poissons_ratio=poissons_ratio)
