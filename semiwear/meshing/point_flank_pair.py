"""A pair of flanks given as points, on axes that may lie anywhere: crossed, intersecting or parallel.

The separation of a driven point is found as for every pair: the driving body is turned about its axis until its flank
passes through the point. The rotation keeps radius and axial place, so that two equations in the two parameters of
the driving surface give the mating point; the touching rotation is the difference of polar angles, and the
separation is that rotation, less the nominal one, times the lever arm of the driving flank's normal. On an involute,
which is its own parallel surface, that is exact; elsewhere to the second order of the separation over the radius of
curvature (Litvin and Fuentes 2004, ch. 9).

Roll positions count from where the nominal flanks slide along their teeth, not across them, on their path of
contact; the rotations follow from the numbers of teeth and from the flanks touching there. `point_pitch` has the
pitch point and the pitch surfaces.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import pi

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.geometry.point_grid import PlacedSection
from semiwear.meshing.flank_pair import ARCSEC, BODIES, DRIVEN, DRIVING, Borders, Meeting, PrismBody, displacement
from semiwear.meshing.point_flank_body import FlankBody, Touch
from semiwear.meshing.point_flank_kernels import meet
from semiwear.meshing.point_flank_sections import drawn_sections, normal_module, placed_sections
from semiwear.meshing.point_pitch import PitchSurface
from semiwear.meshing.tooth_contact import contact_points
from semiwear.scene import FlankPointsPair, Placement
from semiwear.scene.cylindrical import EDGE_RADIUS

_SAMPLES = np.linspace(-0.3, 1.3, 129)  # across a flank, to find a height
_POLISHES = 4
_TURNS_ON = 3
_ABOUT = np.linspace(-0.5, 0.5, 5)  # roll positions among which first touch is searched


@dataclass(frozen=True, eq=False)
class PointFlanks:
    """Two bodies with their flanks, and their rotations when a pair passes the pitch point.

    Attributes
    ----------
    table : FlankPointsPair
    bodies : (FlankBody, FlankBody)
        Driving and driven.
    driven_zero, driving_zero : float [rad]
        Rotations about their own axes at roll 0.
    pitch_point : (3,) array [mm]
    pitch_surfaces : (PitchSurface, PitchSurface)
    lever : float [mm]
        Approach along the normal per rotation of the driving body, where contact passes at roll 0.
    sections : (tuple of PlacedSection, tuple of PlacedSection)
        Tooth sections of the files; empty where they hold none.
    tooth_lengths : (float or None, float or None) [mm]
        Lengths of the teeth of these sections; None: the length in the middle of the flank.
    """

    table: FlankPointsPair
    bodies: tuple[FlankBody, FlankBody]
    driven_zero: float
    driving_zero: float
    pitch_point: FloatArray
    pitch_surfaces: tuple[PitchSurface, PitchSurface]
    lever: float
    sections: tuple[tuple[PlacedSection, ...], tuple[PlacedSection, ...]]
    tooth_lengths: tuple[float | None, float | None] = (None, None)

    @property
    def driving(self) -> FlankBody:
        """The pinion."""
        return self.bodies[DRIVING]

    @property
    def driven(self) -> FlankBody:
        """The gear."""
        return self.bodies[DRIVEN]

    @property
    def ratio(self) -> float:
        """Rotation of the driven body per rotation of the driving one, without sign."""
        return self.driving.teeth / self.driven.teeth

    @property
    def rotations(self) -> tuple[FloatArray, FloatArray]:
        """Angular velocities of both bodies in the fixed frame, the driving one turning by 1 in a unit of time."""
        driving, driven = self.bodies
        return driving.sense * driving.frame[:, 2], driven.sense * self.ratio * driven.frame[:, 2]

    @cached_property
    def edge_radii(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Roundings of both bodies at tip and ends [mm]."""
        return self._radii_of(DRIVING), self._radii_of(DRIVEN)

    def _radii_of(self, body: int) -> tuple[float, float]:
        given = tuple(getattr(self.table, f"{BODIES[body]}_{edge}_edge_radius_mm") for edge in ("tip", "end"))
        default = 0.0
        if "auto" in given:
            default = EDGE_RADIUS.formula(normal_module(self.bodies[body], self.pitch_surfaces[body]))
        tip, end = (default if radius == "auto" else float(radius) for radius in given)
        return tip, end


@dataclass(frozen=True, eq=False)
class PointFlankMesh:
    """Two flanks given as points, in mesh (a `FlankPair`).

    Attributes
    ----------
    flanks : PointFlanks
    placement : Placement
        Rigid displacement of the pinion from its nominal place.
    turned_on : float [rad]
        Rotation of the pinion beyond its nominal one, see `placed`.
    """

    flanks: PointFlanks
    placement: Placement
    turned_on: float = 0.0

    @classmethod
    def placed(cls, flanks: PointFlanks, placement: Placement) -> PointFlankMesh:
        """The flanks with a displaced pinion, turned on until they touch again about the pitch point.

        A common rotation is no transmission error, but would add to the separation: with lever arms that
        vary along the flank, the least separation is at the point of first touch only if it is about zero.
        """
        mesh = cls(flanks, placement)
        if placement.is_aligned:
            return mesh
        for _ in range(_TURNS_ON):
            points = contact_points(mesh, _ABOUT)
            gap = points.separation / mesh.lever_arm(points.position)
            mesh = replace(mesh, turned_on=mesh.turned_on + flanks.driving.sense * float(gap.min()))
        return mesh

    @property
    def difference_steps(self) -> tuple[float, float]:
        """Steps well within a patch between measured points."""
        return 3e-4, 5e-4

    @property
    def face_limits(self) -> tuple[float, float]:
        """Ends of the driven flank [mm]."""
        return self.flanks.driven.face_limits

    @property
    def base_pitch(self) -> float:
        """Travel of contact along the normal at the pitch point in one roll [mm]."""
        return 2.0 * pi * self.flanks.lever / self.flanks.driving.teeth

    @property
    def base_profiles(self) -> tuple[float, float]:
        """Profile coordinates of the base circles of flanks that are involutes [mm]."""
        return self.flanks.driving.base_profile, self.flanks.driven.base_profile

    @property
    def roll_per_time(self) -> float:
        """Pinion teeth per radian."""
        return self.flanks.driving.teeth / (2.0 * pi)

    @property
    def arcsec_per_mm(self) -> float:
        """Gear rotation per approach along the normal at the pitch point [arcsec/mm]."""
        return self.flanks.ratio / self.flanks.lever * ARCSEC

    @property
    def normal_per_arc(self) -> float:
        """Normal distance between flanks per arc of the pinion's pitch circle."""
        return self.flanks.lever / self.flanks.pitch_surfaces[DRIVING].radius

    @property
    def driving_meshes(self) -> float:
        """N2/N1: a pinion tooth meshes more often than a gear tooth."""
        return 1.0 / self.flanks.ratio

    @property
    def pitch_point(self) -> FloatArray:
        """Pitch point in the fixed frame [mm]."""
        return self.flanks.pitch_point

    @property
    def surface_errors(self) -> tuple[float, float]:
        """Estimated errors of both surfaces along their normals [mm]."""
        driving, driven = (body.surface.error for body in self.flanks.bodies)
        return driving, driven

    # ---- kinematics

    @cached_property
    def _driving_place(self) -> tuple[FloatArray, FloatArray]:
        """Frame and origin of the displaced pinion."""
        rotation, shift = displacement(self.placement)
        driving, pivot = self.flanks.driving, self.flanks.pitch_point
        return rotation @ driving.frame, rotation @ (driving.centre - pivot) + pivot + shift

    def meeting(self, face: FloatArray, profile: FloatArray, roll: FloatArray) -> Meeting:
        """Separation by the touching rotation of the driving flank, see the module."""
        driving, driven = self.flanks.bodies
        face, profile = np.broadcast_arrays(np.asarray(face, float), np.asarray(profile, float))
        roll = np.asarray(roll, float)
        shape = np.broadcast_shapes(face.shape, roll.shape)
        v = driven.v_at(face)
        own, normals = driven.points(driven.u_at(profile, driven.profile_length(v)), v)
        rolls = np.broadcast_to(roll, shape).ravel()
        turn = self.flanks.driven_zero + driven.sense * 2.0 * pi / driven.teeth * rolls
        frame, centre = self._driving_place
        position, normal, local = (np.empty((rolls.size, 3)) for _ in range(3))
        spread = (*shape, 3)
        meet(
            np.broadcast_to(own, spread).reshape(-1, 3), np.broadcast_to(normals, spread).reshape(-1, 3), turn,
            driven.frame, driven.centre, np.ascontiguousarray(frame), centre, position, normal, local,
        )  # fmt: skip
        touched = driving.touch(local[:, 0], local[:, 1])
        nominal = self.flanks.driving_zero + self.turned_on + driving.sense * 2.0 * pi / driving.teeth * rolls
        ahead = local[:, 2] - touched.polar - nominal
        ahead -= 2.0 * pi * np.round(ahead / (2.0 * pi))
        return Meeting(
            separation=(driving.sense * ahead * touched.lever).reshape(shape),
            position=position.reshape(spread),
            normal=normal.reshape(spread),
            driving_profile=driving.profile_at(touched.u, driving.mean_length).reshape(shape),
            driving_face=driving.face_at(touched.v).reshape(shape),
        )

    def sliding(self, position: FloatArray) -> FloatArray:
        """Velocity of the pinion minus that of the gear [mm per radian of pinion rotation]."""
        frame, centre = self._driving_place
        axis = self.flanks.driving.sense * frame[:, 2]
        return np.cross(axis, position - centre) - self.driven_velocity(position)

    def driven_velocity(self, position: FloatArray) -> FloatArray:
        """Velocity of the gear [mm per radian of pinion rotation]."""
        return np.cross(self.flanks.rotations[DRIVEN], position - self.flanks.driven.centre)

    def lever_arm(self, position: FloatArray) -> FloatArray:
        """Approach along the driving flank's normal per rotation [mm], where it passes through the positions."""
        return self._held(position).lever.reshape(position.shape[:-1])

    def _held(self, position: FloatArray) -> Touch:
        frame, centre = self._driving_place
        local = (position.reshape(-1, 3) - centre) @ frame
        return self.flanks.driving.touch(np.hypot(local[:, 0], local[:, 1]), local[:, 2].copy())

    # ---- the flanks

    def borders(self, face: FloatArray, *, sharp: bool = False) -> Borders:
        """Limits of both flanks: the outermost rows and columns of their points."""
        driving, driven = self.flanks.bodies
        (driving_tip_radius, driving_end_radius), (tip_radius, end_radius) = self.flanks.edge_radii
        face = np.asarray(face, float)
        keep = 0.0 if sharp else 1.0
        v = driven.v_at(face)
        tip_turn = driven.tip_turn(np.clip(v, 0.0, 1.0))
        driving_turn = self._driving_tip_turn
        return Borders(
            root=np.zeros(face.shape),
            tip=driven.profile_length(v) - keep * tip_radius * np.tan(0.5 * tip_turn),
            driving_root=0.0,
            driving_tip=driving.mean_length - keep * driving_tip_radius * float(np.tan(0.5 * driving_turn)),
            face=driven.face_limits,
            driving_face=driving.face_limits,
            tip_turn=tip_turn,
            driving_tip_turn=driving_turn,
            tip_edge_radius=tip_radius,
            end_edge_radius=end_radius,
            driving_tip_edge_radius=driving_tip_radius,
            driving_end_edge_radius=driving_end_radius,
        )

    @cached_property
    def _driving_tip_turn(self) -> float:
        return float(np.mean(self.flanks.driving.tip_turn(np.linspace(0.0, 1.0, 21))))

    def flank_place(self, body: int, face: FloatArray, profile: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Height above the pitch surface, normal to it, and radius about the body's own axis [mm]."""
        own = self.flanks.bodies[body]
        v = own.v_at(face)
        length = own.mean_length if body == DRIVING else own.profile_length(v)
        radius, axial = own.radius_and_axial(own.u_at(profile, length), v)
        return self.flanks.pitch_surfaces[body].height(radius, axial), radius

    def profile_at(self, face: FloatArray, height: FloatArray) -> FloatArray:
        """Profile coordinate of the gear's flank at a height above its pitch surface [mm]."""
        driven, pitch = self.flanks.driven, self.flanks.pitch_surfaces[DRIVEN]
        face, height = np.broadcast_arrays(np.asarray(face, float), np.asarray(height, float))
        v, target = driven.v_at(face).ravel(), height.ravel()
        heights = pitch.height(*driven.radius_and_axial(_SAMPLES[:, None], v))
        rows = np.arange(v.size)
        # the last place below: heights grow from root to tip
        low = np.clip(np.sum(heights < target, axis=0) - 1, 0, _SAMPLES.size - 2)
        slope = (heights[low + 1, rows] - heights[low, rows]) / (_SAMPLES[1] - _SAMPLES[0])
        u = _SAMPLES[low] + (target - heights[low, rows]) / slope
        for _ in range(_POLISHES):
            u = u + (target - pitch.height(*driven.radius_and_axial(u, v))) / slope
        return driven.profile_at(u, driven.profile_length(v)).reshape(face.shape)

    def pitch_profile(self, face: FloatArray) -> FloatArray:
        """Profile coordinate where the gear's flank crosses its pitch surface [mm]."""
        return self.profile_at(face, np.zeros(np.shape(face)))

    def driving_points(self, face: FloatArray, profile: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points and unit normals of the pinion's surface in its own frame."""
        own = self.flanks.driving
        return own.points(own.u_at(profile, own.mean_length), own.v_at(face))

    def prism_body(self, body: int) -> PrismBody:
        """Sections of the file, or sections drawn from the points and the scene's fields."""
        flanks, mean = self.flanks, body == DRIVING
        if flanks.sections[body]:
            return placed_sections(flanks.bodies[body], flanks.sections[body], mean, flanks.tooth_lengths[body])
        return drawn_sections(flanks.table, body, flanks.bodies[body], flanks.pitch_surfaces[body], mean)
