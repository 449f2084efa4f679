"""Cylindrical pairs in finite elements: motion, flanks, fillets and meshes, beside the core's and closed forms."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

import semiwear as sw
from fem_reference import simulate, tooth_influence
from fem_reference.cylindrical_mesh import CylindricalSurface
from fem_reference.cylindrical_motion import CylindricalMotion
from fem_reference.elasticity import ElasticBody
from fem_reference.hexahedra import MeshError
from fem_reference.pair_motion import line_speed
from fem_reference.pairs import body_mesh, pair_motion
from fem_reference.pitch_blocks import depth_corners
from fem_reference.rigid_lines import RigidFlank
from fem_reference.root_stress import fillet_operator
from fem_reference.tooth_mesh import LOADED, Divisions
from fem_reference.wear import face_stations, flank_profile, wear_depth_of
from semiwear.errors import SceneError
from semiwear.geometry.involute import InvoluteTooth
from semiwear.meshing.pairs import flank_pair, on_loaded_flank
from semiwear.scene import Placement

INTERNAL = {
    "gear_pair.gear_teeth": -60, "gear_pair.centre_distance_mm": None, "gear_pair.gear_profile_shift": 0.0,
    "gear_pair.pinion_profile_shift": 0.2,
}  # fmt: skip
HELICAL = {"gear_pair.helix_angle_deg": 15.0, "gear_pair.centre_distance_mm": None}
KINDS = {
    "spur": {},
    "helical": HELICAL,
    "left hand": HELICAL | {"gear_pair.hand": "left"},
    "internal": INTERNAL,
    "internal helical": INTERNAL | {"gear_pair.helix_angle_deg": 12.0},
    "offset faces": HELICAL | {"gear_pair.face_offset_mm": 3.0, "gear_pair.gear_face_width_mm": 20.0},
    "coast": HELICAL | {"operation.loaded_flank": "coast"},
}
DISPLACED = Placement(
    offset_mm=0.02, axial_pinion_mm=0.3, axial_gear_mm=-0.05, shaft_angle_error_mrad=0.7, pinion_slope_mrad=-0.4
)


def scene_of(spur: sw.Scene, kind: str) -> sw.Scene:
    return spur.replace(KINDS[kind]) if KINDS[kind] else spur


def motion_of(spur: sw.Scene, kind: str, placement: Placement | None = None) -> CylindricalMotion:
    motion = pair_motion(scene_of(spur, kind), placement)
    assert isinstance(motion, CylindricalMotion)
    return motion


@pytest.mark.parametrize("placement", [Placement(), DISPLACED])
@pytest.mark.parametrize("kind", KINDS)
def test_flanks_part_and_slide_as_in_the_core(spur: sw.Scene, kind: str, placement: Placement) -> None:
    """Two ways to write the same pair: poses and meshes here, closed forms in the fixed frame there."""
    scene = scene_of(spur, kind)
    core = flank_pair(*on_loaded_flank(scene.gear_pair, placement, scene.operation.loaded_flank))
    moved = placement
    if kind == "coast":
        moved = replace(placement, offset_mm=-placement.offset_mm, pinion_slope_mrad=-placement.pinion_slope_mrad)
    motion = motion_of(spur, kind, moved)
    face = np.linspace(*motion.gear_face, 5)[:, None]
    profile = np.linspace(motion.gear.root_profile, float(motion.gear.tip_profile(np.array(0.0))), 9)
    for roll in (-0.6, 0.0, 0.3):
        ours, theirs = motion.meeting(face, profile, roll), core.meeting(face, profile, np.array(roll))
        close = {"atol": 1e-11, "rtol": 0.0}
        np.testing.assert_allclose(ours.gap, theirs.separation, **close)
        np.testing.assert_allclose(ours.position, theirs.position, **close)
        np.testing.assert_allclose(ours.normal, theirs.normal, **close)
        np.testing.assert_allclose(ours.pinion_profile, theirs.driving_profile, **close)
        np.testing.assert_allclose(ours.pinion_face, theirs.driving_face, **close)
        np.testing.assert_allclose(motion.sliding(ours.position), core.sliding(theirs.position), **close)
    assert motion.arcsec_per_mm == pytest.approx(core.arcsec_per_mm, rel=1e-13)


@pytest.mark.parametrize("kind", KINDS)
def test_teeth_lie_where_their_poses_say(spur: sw.Scene, kind: str) -> None:
    """Pair j stands at a roll position as pair 0 does j later; a body turned to zero has its tooth j at tooth 0."""
    motion = motion_of(spur, kind)
    for name, flank, pose, tooth in (
        ("pinion", motion.pinion, motion.pinion_pose, 1), ("gear", motion.gear, motion.gear_pose, -1),
    ):  # fmt: skip
        surface = CylindricalSurface(flank, (-7.0, 7.0), name)
        profile = np.linspace(flank.root_profile, float(flank.tip_profile(np.array(0.0))), 5)
        section, normal = surface.flank(profile, 2.0)
        own, outward = flank.points(np.array(2.0), profile)
        np.testing.assert_allclose(surface.to_space(section, 2.0, 0), own, atol=1e-12)
        frame = surface.directions(section[:, 0], 2.0, 0)
        np.testing.assert_allclose(np.einsum("na,nai->ni", normal, frame), outward, atol=1e-13)
        neighbour = surface.to_space(section, 2.0, tooth)
        np.testing.assert_allclose(pose(0.2).points(neighbour), pose(1.2).points(own), atol=1e-11)
        np.testing.assert_allclose(neighbour @ motion.turned_to_zero(name, 1).T, own, atol=1e-11)
        # normals are normal and point out of the material
        step = 1e-5
        along = flank.points(np.array(2.0), profile + step)[0] - flank.points(np.array(2.0), profile - step)[0]
        axial = flank.points(np.array(2.0 + step), profile)[0] - flank.points(np.array(2.0 - step), profile)[0]
        for tangent in (along, axial):
            np.testing.assert_allclose(np.einsum("ni,ni->n", tangent, outward), 0.0, atol=1e-5 * step)
        inside = surface.to_space(0.5 * section + [0.0, 0.5] * section, 2.0, 0)
        assert (np.einsum("ni,ni->n", own - inside, outward) > 0.0).all()


def test_fillet_of_a_spur_tooth_is_the_racks(spur: sw.Scene) -> None:
    flank = motion_of(spur, "spur").pinion
    tooth = flank.tooth
    involute = InvoluteTooth(
        teeth=16, module=4.5, pressure_angle=tooth.normal_pressure_angle, addendum=5.0,
        rack_addendum=tooth.rack_addendum, rack_tip_radius=tooth.rack_tip_radius, bore_radius=20.0,
        profile_shift=tooth.profile_shift * 4.5,
    )  # fmt: skip
    angle, radius = flank.fillet(41)
    np.testing.assert_allclose(np.column_stack([radius * np.sin(angle), radius * np.cos(angle)]), involute.fillet(41))


@pytest.mark.parametrize("body", ["pinion", "gear"])
@pytest.mark.parametrize("kind", KINDS)
def test_fillets_join_flank_and_root(spur: sw.Scene, kind: str, body: str) -> None:
    """At the end of the involute with a common tangent, on the root circle at right angles to the radius."""
    flank = getattr(motion_of(spur, kind), body)
    tooth = flank.tooth
    angle, radius = flank.fillet(2001)
    first = tooth.form_roll_angle
    assert radius[0] == pytest.approx(tooth.base_radius * np.hypot(1.0, first), rel=1e-12)
    assert angle[0] == pytest.approx(float(flank.half_angle(np.array(first))), rel=1e-11)
    assert radius[-1] == pytest.approx(tooth.root_radius, rel=1e-12)
    assert angle[-1] <= pi / tooth.teeth
    slope = np.gradient(radius * angle, radius)
    step = 1e-5
    there = np.array([first - step, first + step])
    wanted = np.diff(tooth.base_radius * np.hypot(1.0, there) * flank.half_angle(there))
    wanted = wanted / np.diff(tooth.base_radius * np.hypot(1.0, there))
    assert slope[0] == pytest.approx(wanted[0], abs=0.01)
    assert abs(radius[-1] - radius[-2]) < 0.01 * abs(angle[-1] - angle[-2]) * radius[-1]


@pytest.mark.parametrize("kind", ["spur", "internal helical"])
@pytest.mark.parametrize("body", ["pinion", "gear"])
def test_meshes_lie_on_their_flanks(spur: sw.Scene, kind: str, body: str) -> None:
    scene = scene_of(spur, kind)
    mesh = body_mesh(scene, body, teeth=3, divisions=Divisions(4, 4, 1, 2, 2, 4.0))
    own = getattr(motion_of(spur, kind), body)
    flank = mesh.flanks[0, LOADED]
    points, normals = own.points(np.broadcast_to(flank.face, flank.profile.shape), flank.profile)
    np.testing.assert_allclose(mesh.mesh.p.T[flank.nodes], points, atol=1e-12)
    np.testing.assert_allclose(flank.normals, normals, atol=1e-13)
    held = np.hypot(*mesh.mesh.p[:2, mesh.held])
    outer = own.tooth.root_radius - own.tooth.side * own.tooth.rim_thickness
    np.testing.assert_allclose(held, outer, rtol=1e-12)


def test_a_whole_ring_closes(spur: sw.Scene) -> None:
    divisions = Divisions(2, 2, 1, 1, 1, 14.0)
    ring = body_mesh(spur, "pinion", teeth=99, divisions=divisions, detailed=())
    sector = body_mesh(spur, "pinion", teeth=15, divisions=divisions, detailed=())
    assert len(ring.teeth) == 16
    apiece = (ring.mesh.nelements - sector.mesh.nelements, ring.mesh.nvertices / 16)
    assert ring.mesh.nelements == 16 * apiece[0]
    assert apiece[1] == int(apiece[1])


@pytest.mark.parametrize("kind", ["spur", "helical", "internal"])
def test_conjugate_flanks_touch_along_their_whole_line(spur: sw.Scene, kind: str) -> None:
    """And the line moves over the flank as it rolls off the base cylinder."""
    motion = motion_of(spur, kind)
    rigid = RigidFlank(motion)
    line = rigid.line(0.1)
    assert np.abs(line.gap).max() < 3e-7
    before, after = (rigid.line(0.1 + shift) for shift in (-0.02, 0.02))
    moved = [motion.gear_pose(one.roll).back(one.position) for one in (before, after)]
    speed = line_speed(motion, moved[0], moved[1], 0.04)
    # over the gear's flank: roll angle times base radius for each radian of the gear; the line is a straight one,
    # at right angles to the transverse involute
    wanted = motion.ratio * motion.gear.tooth.base_radius * motion.gear.roll_from_profile(line.profile)
    np.testing.assert_allclose(speed, wanted, rtol=2e-3)


@pytest.mark.slow
def test_wear_lies_on_the_grid_of_the_core(spur: sw.Scene) -> None:
    """A `/flank` group and a bare array say the same."""
    scene = spur.replace({"wear.worn_bodies": ("gear",), "numerics.wear_steps": 1, "wear.until.meshes": 1e7})
    flank = sw.simulate(scene)["flank"].to_dataset()
    pair = pair_motion(scene)
    height = flank.flank_height.sel(body="gear").values
    profile = flank_profile(pair, face_stations(pair))
    radius = pair.gear.tooth.base_radius * np.hypot(1.0, pair.gear.roll_from_profile(profile))
    np.testing.assert_allclose(radius - pair.gear.working_radius, height, atol=1e-9)
    face = np.linspace(-6.0, 6.0, 7)
    profile = np.linspace(-3.0, 3.0, 7)
    whole, bare = wear_depth_of(flank, pair), wear_depth_of(flank.wear_depth.isel(wear_step=-1).values, pair)
    assert bare.depth(face, profile).max() > 1e-5
    np.testing.assert_allclose(whole.depth(face, profile), bare.depth(face, profile), atol=1e-9)


def test_pointed_and_undercut_teeth_are_refused(spur: sw.Scene) -> None:
    own = motion_of(spur, "spur").pinion
    pointed = replace(own, tooth=replace(own.tooth, tip_radius=46.0))
    with pytest.raises(MeshError, match="pointed"):
        CylindricalSurface(pointed, (-7.0, 7.0), "pinion").profile_limits(0.0)
    undercut = replace(own, tooth=replace(own.tooth, profile_shift=-0.4))
    with pytest.raises(MeshError, match="undercut"):
        CylindricalSurface(undercut, (-7.0, 7.0), "pinion").profile_limits(0.0)


def test_what_knows_face_gears_only_says_so(spur: sw.Scene) -> None:
    for refused in (lambda: tooth_influence(spur), lambda: simulate(spur.replace(
        {"wear.worn_bodies": ("gear",)}))):  # fmt: skip
        with pytest.raises(SceneError, match=r"gear_pair\.type.*loaded_contact takes cylindrical pairs"):
            refused()


@pytest.mark.parametrize("name", ["pinion", "gear"])
def test_root_stress_is_read_normal_to_the_tooth(name) -> None:
    """ISO 6336-3:2019, 5: root stress of helical teeth is that of the normal section, not of the transverse one."""
    divisions = Divisions(flank=3, fillet=4, land=1, across=2, depth=2, face_size=3.0)
    changed = sw.load_scene("spur_fzg_c").replace(HELICAL | {"gear_pair.helix_angle_deg": 30.0})
    mesh = body_mesh(changed, name, element="hex20", teeth=3, divisions=divisions)
    e, nu = 206000.0, 0.3
    body = ElasticBody(mesh.mesh, element="hex20", youngs_modulus=e, poissons_ratio=nu)
    fillet = mesh.fillets[0, LOADED]
    # the tooth's direction, from neighbouring places of the same height
    points, down = fillet.points[:, ::2], fillet.tangents[:, ::2]
    trace = np.gradient(points, axis=1)
    trace /= np.linalg.norm(trace, axis=-1, keepdims=True)
    lean = np.degrees(np.arccos(np.abs(trace[0, :, 2])))
    assert np.all((lean > 25.0) & (lean < 33.0))
    normal = np.cross(down, trace)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    across = np.cross(trace, normal)
    strain = 1e-4 * np.array([[2.0, 0.5, -0.7], [0.5, -1.0, 0.4], [-0.7, 0.4, 1.5]])
    expected = sum(
        factor * np.einsum("afi,ij,afj->af", way, strain, way) for way, factor in ((across, 1.0), (trace, nu))
    )
    found = (fillet_operator(body, mesh) @ (body.points @ strain).ravel()).reshape(expected.shape)
    np.testing.assert_allclose(found, e / (1.0 - nu**2) * expected, atol=0.03 * np.abs(found).max())


def test_elements_below_the_root_start_as_small_as_those_of_the_fillet() -> None:
    """However thick the body is: five of them raised root stress by 3 to 7 % above 45 mm of steel."""
    few = Divisions(flank=10, fillet=8, land=1, across=6, depth=5, face_size=3.0)
    for rim, count in ((8.0, 5), (40.0, 10)):
        pair = pair_motion(sw.load_scene("spur_fzg_c").replace({"gear_pair.gear_rim_thickness_mm": rim}))
        assert isinstance(pair, CylindricalMotion)
        surface = CylindricalSurface(pair.gear, (-7.0, 7.0), "gear")
        fillet = surface.fillet(0.0)
        element = np.hypot(*np.diff(fillet, axis=0).T).sum() / 8
        steps = rim * np.diff(depth_corners(surface, np.array([0.0]), replace(few, deeper=True)))
        assert len(steps) == count
        assert steps[0] <= 1.01 * element
        assert np.all(np.diff(steps) > 0.0)
        assert len(depth_corners(surface, np.array([0.0]), few)) == 6
