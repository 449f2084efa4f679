"""Pictures of a scene's teeth without a run: in mesh, as sections, and with the path of contact.

Lengths are in mm. In the mesh the pitch point is the origin, the pinion lies above, and the drive flanks touch; if
the scene loads the coast flank, the picture is mirrored.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import cos, pi, sin
from typing import TYPE_CHECKING

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.errors import SemiwearError
from semiwear.geometry.section import RingRim, ToothSection
from semiwear.meshing.cylindrical_pair import CylindricalMesh
from semiwear.meshing.face_gear_pair import FaceGearMesh
from semiwear.meshing.flank_pair import BODIES, DRIVEN, FlankPair
from semiwear.meshing.pairs import flank_pair
from semiwear.meshing.tooth_contact import unloaded_contact
from semiwear.plot.style import BODY_COLOUR, axes_for, step_colours, styled
from semiwear.scene import Placement, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SIZE = (6.2, 5.2)
_PITCHES = 1.6  # in the picture of a mesh, to each side of the pitch point
_FILL = 0.16  # opacity of a body
_DARK = "#222222"


def teeth_in_mesh(scene: Scene, ax: Axes | None = None) -> Axes:
    """Both bodies in mesh at the pitch point with the path of contact, in the transverse section of the pinion.

    Of a face gear the developed section at its pitch radius is drawn.

    Parameters
    ----------
    scene : Scene
    ax : Axes, optional
        Where to draw; a new figure unless given.

    Raises
    ------
    SemiwearError
        Flanks given as points have no transverse section: draw `tooth_sections` and `path_on_flank`.
    """
    mesh = flank_pair(scene.gear_pair, Placement())
    if not isinstance(mesh, CylindricalMesh | FaceGearMesh):
        raise SemiwearError("teeth_in_mesh: flanks as points have no transverse section; see tooth_sections")
    side = 1.0 if scene.operation.loaded_flank == "drive" else -1.0
    with styled():
        (ax,) = axes_for(ax, size=_SIZE)
        if isinstance(mesh, CylindricalMesh):
            _draw_cylindrical(ax, mesh, side)
        else:
            _draw_face_gear(ax, mesh, side)
        ax.set(xlabel="Across the line of centres (mm)", ylabel="Above the pitch point (mm)", aspect="equal")
        ax.set_title(f"{scene.gear_pair.description[:1].upper()}{scene.gear_pair.description[1:]}")
        ax.grid(False)
    return ax


@styled()
def tooth_sections(scene: Scene, body: str = "gear", ax: Axes | None = None) -> Axes:
    """Sections of a body's tooth: of a face gear at several radii, of other gears where sections are given.

    Parameters
    ----------
    scene : Scene
    body : str
        ``"pinion"`` or ``"gear"``.
    ax : Axes, optional
        Where to draw; a new figure unless given.
    """
    (ax,) = axes_for(ax, size=_SIZE)
    mesh, index = flank_pair(scene.gear_pair, Placement()), BODIES.index(body)
    drawn = mesh.prism_body(index)
    colours = step_colours(len(drawn.sections)) if len(drawn.sections) > 1 else [BODY_COLOUR[body]]
    for face, section, colour in zip(drawn.faces, drawn.sections, colours, strict=True):
        x, y = _both_sides(section)
        y = y + _above_pitch(mesh, index, face, section)
        at = "radius" if scene.gear_pair.type == "face_gear" else "at"
        ax.plot(x, y, color=colour, label=f"{at} {face:.1f} mm" if len(drawn.sections) > 1 else None)
    ax.axhline(0.0, color="#999999", lw=0.8, ls="--")
    ax.set(xlabel="Across the tooth (mm)", ylabel=f"Above the {_surface(scene, body)} (mm)", aspect="equal")
    ax.set_title(
        f"Tooth of the {body}, normal to it" if scene.gear_pair.type != "face_gear" else f"Tooth of the {body}"
    )
    if len(drawn.sections) > 1:
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return ax


@styled()
def path_on_flank(scene: Scene, ax: Axes | None = None) -> Axes:
    """The unloaded path of contact on the gear's flank, between its root end and its tip.

    Parameters
    ----------
    scene : Scene
    ax : Axes, optional
        Where to draw; a new figure unless given.

    Raises
    ------
    SceneError
        The flanks do not meet.
    """
    (ax,) = axes_for(ax, size=_SIZE)
    mesh = flank_pair(scene.gear_pair, Placement())
    face = np.linspace(*mesh.face_limits, 81)
    borders = mesh.borders(face)
    colour = BODY_COLOUR["gear"]
    root, tip = (mesh.flank_place(DRIVEN, face, ends)[0] for ends in (borders.root, borders.tip))
    ax.fill_between(face, root, tip, color=colour, alpha=_FILL, lw=0.0)
    ax.plot(face, tip, color=colour)
    ax.plot(face, root, color=colour)
    ax.annotate("tip", (face[12], tip[12]), (0, 3), textcoords="offset points", ha="center", color=colour)
    ax.annotate(
        "end of the flank", (face[60], root[60]), (0, -11), textcoords="offset points", ha="center", color=colour
    )
    ax.axhline(0.0, color="#999999", lw=0.8, ls="--")
    contact = unloaded_contact(mesh)
    height = mesh.flank_place(DRIVEN, contact.points.face, contact.points.profile)[0]
    ax.plot(contact.points.face, height, color=_DARK, lw=2.2)
    ax.annotate(
        f"path of contact, contact ratio {contact.contact_ratio:.3f}", (contact.points.face[-1], height[-1]),
        (6, 0), textcoords="offset points", color=_DARK, va="center",
    )  # fmt: skip
    along = "Gear radius (mm)" if scene.gear_pair.type == "face_gear" else "Along the face (mm)"
    ax.set(xlabel=along, ylabel=f"Above the {_surface(scene, 'gear')} (mm)")
    ax.margins(y=0.12)
    ax.set_title("Path of contact on the gear's flank")
    return ax


_PINION, _GEAR = (partial(tooth_sections, body=body) for body in BODIES)
_PANELS: dict[str, tuple[Callable[..., Axes], ...]] = {
    "cylindrical": (teeth_in_mesh,),
    "face_gear": (teeth_in_mesh, _GEAR, path_on_flank),
}
_OTHERS = (_PINION, _GEAR, path_on_flank)


@styled()
def geometry_figure(scene: Scene) -> Figure:
    """A figure with all pictures of a scene's teeth, as saved by `semiwear geometry`."""
    from matplotlib.figure import Figure

    panels = _PANELS.get(scene.gear_pair.type, _OTHERS)
    figure = Figure(figsize=(_SIZE[0] * len(panels), _SIZE[1]), layout="constrained")
    for panel, ax in zip(panels, figure.subplots(1, len(panels), squeeze=False).flat, strict=True):
        panel(scene, ax=ax)
    return figure


# ---- parts


def _surface(scene: Scene, body: str) -> str:
    return scene.gear_pair.pitch_surfaces[1 + BODIES.index(body)]


def _both_sides(section: ToothSection) -> tuple[FloatArray, FloatArray]:
    """Outline of a tooth from the middle of one tooth space to that of the next."""
    half = np.concatenate([section.flank, section.fillet[1:]])
    if isinstance(section.rim, RingRim):
        radius = float(np.hypot(*section.fillet[-1]))
        middle = radius * np.array([sin(pi / section.rim.teeth), cos(pi / section.rim.teeth)])
    else:
        middle = np.array([0.5 * section.rim.pitch, section.fillet[-1, 1]])
    half = np.vstack([half, middle])
    x = np.concatenate([-half[::-1, 0], half[:, 0]])
    return x, np.concatenate([half[::-1, 1], half[:, 1]])


def _above_pitch(mesh: FlankPair, body: int, face: float, section: ToothSection) -> float:
    """Height above the pitch surface minus height in the section, at the tip [mm]."""
    tip = section.flank[0]
    in_section = float(np.hypot(*tip)) if isinstance(section.rim, RingRim) else float(tip[1])
    above_pitch, _ = mesh.flank_place(body, np.array([face]), section.flank_profile[:1])
    return float(above_pitch[0]) - in_section


def _ring(half: FloatArray, centre_angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Radius and angle along several teeth, from half a tooth as (radius, angle) from tip to tooth space."""
    radius = np.concatenate([half[::-1, 0], half[:, 0]])
    angle = np.concatenate([-half[::-1, 1], half[:, 1]])
    return np.tile(radius, centre_angles.size), (centre_angles[:, None] + angle).ravel()


def _draw_ring(
    ax: Axes, half: FloatArray, body: str, centre: float, middle: float, teeth: int, rim: float, side: float
) -> None:
    """Draw teeth of a ring about (0, `centre`), one of them at the angle `middle` from the pitch point."""
    neighbours = np.arange(-4, 5) * (2.0 * pi / teeth)
    radius, angle = _ring(half, np.asarray(middle + neighbours, float))
    down = -1.0 if centre > 0.0 else 1.0  # from the centre to the pitch point

    def place(r: FloatArray, a: FloatArray) -> tuple[FloatArray, FloatArray]:
        return side * r * np.sin(a), centre + down * r * np.cos(a)

    x, y = place(radius, angle)
    back_x, back_y = place(np.full(61, rim), np.linspace(angle[-1], angle[0], 61))
    colour = BODY_COLOUR[body]
    ax.fill(np.append(x, back_x), np.append(y, back_y), color=colour, alpha=_FILL, lw=0.0)
    ax.plot(x, y, color=colour)


def _circle(ax: Axes, centre: float, radius: float, dashes: str) -> None:
    """Draw a thin arc about (0, `centre`) near the pitch point."""
    down = -1.0 if centre > 0.0 else 1.0
    a = np.linspace(-0.6, 0.6, 121)
    ax.plot(radius * np.sin(a), centre + down * radius * np.cos(a), color="#888888", lw=0.8, ls=dashes)


def _draw_cylindrical(ax: Axes, mesh: CylindricalMesh, side: float) -> None:
    pinion, gear = mesh.pinion, mesh.gear
    pinion_working, gear_working = mesh.working_radii
    centres = pinion_working, -gear.side * gear_working
    for tooth, body, centre, working, sign in (
        (pinion, "pinion", centres[0], pinion_working, 1.0),
        (gear, "gear", centres[1], gear_working, -1.0),
    ):
        half = tooth.transverse_outline()
        middle = sign * tooth.half_thickness(working) / working
        rim = tooth.root_radius - tooth.side * min(tooth.rim_thickness, 2.0 * tooth.normal_module)
        _draw_ring(ax, half, body, centre, middle, int(tooth.teeth), rim, side)
        _circle(ax, centre, working, "--")
        _circle(ax, centre, tooth.base_radius, ":")
    first, last = mesh.path_limits
    _path(ax, first, last, mesh.base_pitch, mesh.table.working_pressure_angle, side)
    reach = _PITCHES * pi * pinion.normal_module / cos(pinion.helix_angle)
    _window(ax, reach, pinion.normal_module)


def _draw_face_gear(ax: Axes, mesh: FaceGearMesh, side: float) -> None:
    tooth, pinion = mesh.gear, mesh.pinion
    section = pinion.section()
    x, y = np.concatenate([section.flank, section.fillet[1:]]).T
    half = np.column_stack([np.hypot(x, y), np.arctan2(x, y)])
    half = np.vstack([half, [pinion.root_radius, pi / pinion.teeth]])
    middle = pi / (2.0 * pinion.teeth)
    rim = max(pinion.bore_radius, pinion.root_radius - 2.0 * pinion.module)
    _draw_ring(ax, half, "pinion", pinion.pitch_radius, middle, int(pinion.teeth), rim, side)
    _circle(ax, pinion.pitch_radius, pinion.pitch_radius, "--")
    _circle(ax, pinion.pitch_radius, pinion.base_radius, ":")
    cut = tooth.section(tooth.pitch_radius)
    x, y = _both_sides(cut)
    pitch = 2.0 * pi * tooth.pitch_radius / tooth.gear_teeth
    middle_x = -float(np.interp(0.0, cut.flank[::-1, 1], cut.flank[::-1, 0]))
    across = (middle_x + pitch * np.arange(-4, 5)[:, None] + x).ravel()
    up = np.tile(y, 9)
    colour = BODY_COLOUR["gear"]
    ax.fill_between(
        side * across, up, -tooth.shaper_addendum - tooth.rim_thickness, color=colour, alpha=_FILL, lw=0.0
    )
    ax.plot(side * across, up, color=colour)
    ax.axhline(0.0, color="#888888", lw=0.8, ls="--")
    contact = unloaded_contact(mesh)
    along = (contact.points.position - mesh.pitch_point)[[0, -1], 1] / sin(pinion.pressure_angle)
    first, last = float(along.max()), float(along.min())
    _path(ax, first, last, mesh.base_pitch, pinion.pressure_angle, side)
    _window(ax, _PITCHES * pi * tooth.module, tooth.module)


def _path(ax: Axes, first: float, last: float, base_pitch: float, angle: float, side: float) -> None:
    """Draw the path of contact through the pitch point, from A at the gear's tip to E at the pinion's."""
    direction = np.array([side * cos(angle), sin(angle)])
    ends = np.outer([first, last], direction)
    ax.plot(*ends.T, color=_DARK, lw=2.2, solid_capstyle="butt")
    points = {"A": first, "C": 0.0, "E": last}
    if base_pitch < first - last < 2.0 * base_pitch:
        points |= {"B": last + base_pitch, "D": first - base_pitch}
    for name, length in points.items():
        place = length * direction
        ax.plot(*place, "o", color=_DARK, ms=4.0)
        ax.annotate(
            name,
            (place[0], place[1]),
            (0, 6),
            textcoords="offset points",
            ha="center",
            color=_DARK,
            fontweight="bold",
        )
    ratio = (first - last) / base_pitch
    ax.annotate(
        f"path of contact A to E: {first - last:.2f} mm, contact ratio {ratio:.3f}", (0.02, 0.02),
        xycoords="axes fraction", color=_DARK,
    )  # fmt: skip


def _window(ax: Axes, reach: float, module: float) -> None:
    """Set the limits of the picture, and write the names of the bodies in their colours."""
    ax.set(xlim=(-reach, reach), ylim=(-4.2 * module, 4.2 * module))
    for body, place in (("pinion", 0.93), ("gear", 0.12)):
        ax.annotate(
            body, (0.98, place), xycoords="axes fraction", ha="right", color=BODY_COLOUR[body], fontweight="bold"
        )
    ax.annotate(
        "dashed: pitch circles; dotted: base circles", (0.02, 0.95), xycoords="axes fraction", color="#666666",
        fontsize=8.5,
    )  # fmt: skip
