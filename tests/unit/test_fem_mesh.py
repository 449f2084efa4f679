"""Meshes of gear and pinion: true surfaces, conforming blocks, refined patches, worn flanks, clear errors."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest

import semiwear as sw
from fem_reference.elasticity import ElasticBody
from fem_reference.face_gear_mesh import face_gear_mesh
from fem_reference.hexahedra import MeshError, equal_shares, with_middles
from fem_reference.line_meshes import MeshSettings, line_meshes
from fem_reference.moved_nodes import moved_flanks
from fem_reference.pairs import body_mesh, pair_motion
from fem_reference.pinion_mesh import pinion_mesh
from fem_reference.rigid_lines import RigidFlank, effective_modulus, forecast
from fem_reference.tooth_mesh import LOADED, OPPOSITE, Divisions, Refinement, ToothMesh
from fem_reference.wear import FlankWear
from semiwear.geometry.involute import InvoluteTooth
from semiwear.scene import load_scene

SCENE = load_scene("face_gear_25x160")
STEEL = {"youngs_modulus": 207000.0, "poissons_ratio": 0.3}
COARSE = Divisions(flank=3, fillet=2, land=1, across=2, depth=3, face_size=20.0)
BUILDERS = [pytest.param(face_gear_mesh, id="gear"), pytest.param(pinion_mesh, id="pinion")]


def with_pair(**changes):
    """The scene with changed gear pair, past the checks that would refuse it."""
    return replace(SCENE, gear_pair=replace(SCENE.gear_pair, **changes))


@pytest.mark.parametrize("build", BUILDERS)
@pytest.mark.parametrize("element", ["hex8i", "hex20", "hex27"])
def test_flank_nodes_lie_on_the_surface(build, element):
    mesh = build(SCENE, element=element, teeth=3, divisions=COARSE)
    body = ElasticBody(mesh.mesh, element=element, **STEEL)
    assert mesh.teeth == (-1, 0, 1)
    for tooth in mesh.teeth:
        for side in (LOADED, OPPOSITE):
            flank = mesh.flanks[tooth, side]
            there = flank.nodes >= 0
            assert (there.all() or element == "hex20") and there[::2, ::2].all()
            np.testing.assert_allclose(body.points[flank.nodes[there]], flank.points[there], atol=1e-9)
            assert (np.diff(flank.profile, axis=0) > 0.0).all()
            np.testing.assert_allclose(np.linalg.norm(flank.normals, axis=-1), 1.0, atol=1e-12)
            slopes = [np.gradient(flank.points, axis=k, edge_order=2) for k in (0, 1)]
            for slope in slopes:
                slope /= np.linalg.norm(slope, axis=-1, keepdims=True)
                # a coarse difference quotient is not quite tangent
                assert np.abs(np.einsum("pfi,pfi->pf", slope, flank.normals)).max() < 0.15
            # outwards: away from the middle of the tooth
            middle = body.points[mesh.middles[tooth][0, 0]]
            assert np.einsum("i,i->", flank.points[-1, 0] - middle, flank.normals[-1, 0]) > 0.0


def test_gear_flank_is_that_of_the_geometry():
    from fem_reference.face_gear_mesh import FaceGearSurface

    mesh = face_gear_mesh(SCENE, teeth=1, divisions=COARSE)
    flank = mesh.flanks[0, LOADED]
    t = SCENE.gear_pair
    from semiwear.geometry.face_gear import FaceGearTooth

    tooth = FaceGearTooth(28, 160, 6.35, radians(25.0), 6.35, 7.9375, 1.27, t.gear_rim_thickness_mm)
    points, normals = tooth.points(np.broadcast_to(flank.face, flank.profile.shape), flank.profile)
    np.testing.assert_allclose(flank.points, points, atol=1e-9)
    np.testing.assert_allclose(flank.normals, normals, atol=1e-12)
    np.testing.assert_allclose(
        np.hypot(flank.points[..., 0], flank.points[..., 2]), np.broadcast_to(flank.face, flank.profile.shape)
    )
    assert FaceGearSurface(tooth, (480.0, 560.0)).foot == pytest.approx(-88.9 - 7.9375 - 15.875)


def test_neighbours_lie_on_the_loaded_side():
    gear = face_gear_mesh(SCENE, teeth=3, divisions=COARSE)
    pinion = pinion_mesh(SCENE, teeth=3, divisions=COARSE)
    for mesh in (gear, pinion):
        here, there = (mesh.flanks[tooth, LOADED] for tooth in (0, 1))
        assert np.einsum("i,i->", there.points[0, 0] - here.points[0, 0], here.normals[0, 0]) > 0.0


@pytest.mark.parametrize("build", BUILDERS)
def test_held_nodes(build):
    mesh = build(SCENE, element="hex20", teeth=1, divisions=COARSE)
    points = ElasticBody(mesh.mesh, element="hex20", **STEEL).points
    if mesh.name == "gear":
        there = np.abs(points[:, 1] - points[:, 1].min()) < 1e-9
    else:
        there = np.abs(np.hypot(points[:, 0], points[:, 1]) - 50.0) < 1e-6
    np.testing.assert_array_equal(np.flatnonzero(there), np.sort(mesh.held))


def test_ring_of_the_pinion_is_whole_and_conforming():
    """Its boundary has as many faces as outline, bore and two ends make; its volume is that of the section."""
    mesh = pinion_mesh(SCENE, element="hex27", divisions=COARSE, detailed=())
    d, face = COARSE.coarse, 4
    outline = 2 * (d.flank + d.across + d.fillet + d.land)
    bore = 2 * (d.across + d.fillet // 2 + d.land)
    plane = 2 * d.across * (d.flank + d.fillet // 2) + COARSE.depth * bore
    assert mesh.mesh.nelements == 25 * plane * face
    assert len(mesh.mesh.boundary_facets()) == 25 * (face * (outline + bore) + 2 * plane)

    body = ElasticBody(mesh.mesh, element="hex27", **STEEL)
    volume = sum(body._gradients(slice(k, k + 400), _rule())[1].sum() for k in range(0, len(body.elements), 400))
    p = SCENE.gear_pair
    tooth = InvoluteTooth(
        25, 6.35, radians(25.0), p.pinion_addendum_mm, p.rack_addendum_mm, p.rack_tip_radius_mm, 50.0
    )
    section = tooth.section()
    half = np.vstack([section.flank, section.fillet[1:]])
    r, phi = np.hypot(*half.T), np.arctan2(half[:, 0], half[:, 1])
    tip, root = 0.5 * r[0] ** 2 * phi[0], 0.5 * r[-1] ** 2 * (np.pi / 25 - phi[-1])
    fan = 0.5 * np.sum(half[1:, 0] * half[:-1, 1] - half[:-1, 0] * half[1:, 1])
    exact = 80.0 * (50 * (tip + fan + root) - np.pi * 50.0**2)
    assert volume == pytest.approx(exact, rel=3e-4)


def _rule():
    from skfem.quadrature import get_quadrature

    from fem_reference.elasticity import ELEMENTS

    return get_quadrature(ELEMENTS["hex27"].element.refdom, 5)


@pytest.mark.parametrize("build", BUILDERS)
def test_refined_patch_follows_its_line(build):
    def line(face):
        return 0.5 - 0.1 * (face - 520.0)

    wanted = Refinement(line, 0.8, (505.0, 535.0), 0.25, 3.0)
    mesh = build(SCENE, teeth=3, refinements={0: wanted}, divisions=COARSE)
    flank, neighbour = mesh.flanks[0, LOADED], mesh.flanks[1, LOADED]
    assert neighbour.nodes.shape[0] == 4
    inside = (flank.face >= 505.0) & (flank.face <= 535.0)
    assert np.diff(flank.face[inside]).max() <= 3.0 + 1e-9
    for k, face in enumerate(flank.face):
        near = np.abs(flank.profile[:, k] - line(face)) <= 0.8
        assert near.sum() >= 6
        assert np.diff(flank.profile[near, k]).max() <= 0.25 + 1e-6
    assert np.diff(flank.profile, axis=0).max() > 4 * 0.25  # coarse elsewhere
    assert np.diff(flank.face).max() > 5.0


@pytest.mark.parametrize("build", BUILDERS)
def test_elements_are_short_where_contact_may_end(build):
    """Short at an end of the tooth and at a place within it, growing evenly from both, as wanted elsewhere."""
    ends = (480.0, 530.0)
    wanted = Refinement(lambda face: 0.0 * face, 0.8, (470.0, 570.0), 0.5, 4.0, 0.6, ends, 0.2)
    face = build(SCENE, teeth=1, refinements={0: wanted}, divisions=COARSE).flanks[0, LOADED].face
    length, middle = np.diff(face), 0.5 * (face[1:] + face[:-1])
    away = np.abs(middle[:, None] - ends).min(axis=1)
    assert length.max() <= 4.0 + 1e-9
    assert length[0] <= 0.25 and length[away < 0.2].max() <= 0.25
    # an element spans places of different wanted sizes: the greatest of them is that of its far end
    assert (length <= 0.2 + 0.25 * (away + 0.5 * length) + 1e-9).all()
    assert len(length) < 60


@pytest.mark.slow
def test_bodies_are_refined_where_either_ends():
    """A pinion narrower than the gear: the gear's elements are short where the pinion ends, which lies within it."""
    scene = with_pair(pinion_face_width_mm=50.0, pinion_end_edge_radius_mm=0.3)
    flank = RigidFlank(pair_motion(scene))
    settings = MeshSettings(elements_per_half_width=1.0, element_length=5.0, gear_teeth=5, pinion_teeth=5)
    torque = 1.6e6
    lines = flank.lines(0.0)
    expected = forecast(lines, -(len(lines) // 2), torque / flank.pair.lever, effective_modulus(scene))
    meshes = line_meshes(flank, 0.0, expected, settings)
    for name, inner in (("gear", 495.0), ("pinion", 495.0)):
        face = meshes[name].flanks[0, LOADED].face
        # contact does not reach the outer end of the pinion here: nothing is spent there
        near = expected.lines[0].face[expected.lines[0].gap - expected.least < 1.5 * expected.approach]
        assert near.min() < 496.0 and near.max() < 545.0
        assert np.diff(face)[np.abs(face[1:] - inner) < 0.5].max() < 0.6
        assert np.diff(face).max() > 2.5


def test_patches_on_two_teeth_share_the_face_stations():
    patches = {
        j: Refinement(lambda face, j=j: 0.0 * face + 2.0 * j, 0.5, (500.0 - 10 * j, 510.0), 0.5, 4.0) for j in (0, 1)
    }
    mesh = face_gear_mesh(SCENE, teeth=3, refinements=patches, divisions=COARSE)
    assert mesh.flanks[0, LOADED].nodes.shape[0] > 10 < mesh.flanks[1, LOADED].nodes.shape[0]
    face = mesh.flanks[0, LOADED].face
    assert np.diff(face[(face >= 490.0) & (face <= 510.0)]).max() <= 4.0 + 1e-9


def test_patch_beyond_tip_and_ends_still_meshes():
    beyond = Refinement(lambda face: 9.0 + 0.0 * face, 1.0, (550.0, 600.0), 0.3, 3.0)
    flank = face_gear_mesh(SCENE, teeth=1, refinements={0: beyond}, divisions=COARSE).flanks[0, LOADED]
    assert np.isfinite(flank.points).all()


@pytest.mark.parametrize("element", ["hex8i", "hex20"])
def test_near_pointed_and_near_undercut_ends_mesh(element):
    scene = with_pair(gear_inner_radius_mm=466.0, gear_outer_radius_mm=568.0)
    mesh = face_gear_mesh(scene, element=element, teeth=1, divisions=COARSE)
    assert mesh.mesh.nelements > 0


@pytest.mark.parametrize(
    ("build", "changes", "message"),
    [
        (face_gear_mesh, {"gear_outer_radius_mm": 575.0}, "pointed at radius"),
        (face_gear_mesh, {"gear_inner_radius_mm": 460.0}, "undercut at radius 460"),
        (face_gear_mesh, {"gear_rim_thickness_mm": -1.0}, "rim thicker"),
        (pinion_mesh, {"pinion_addendum_mm": 16.0}, "pointed at its tip"),
        (pinion_mesh, {"pinion_teeth": 9, "pinion_bore_radius_mm": 10.0, "pinion_addendum_mm": 3.0}, "undercuts"),
        (pinion_mesh, {"pinion_bore_radius_mm": 75.0}, "rim thicker"),
    ],
)
def test_impossible_teeth_are_named(build, changes, message):
    with pytest.raises(MeshError, match=message):
        build(with_pair(**changes), teeth=1, divisions=COARSE)


def test_bad_requests_are_named():
    patch = Refinement(lambda face: 0.0 * face, 0.5, (500.0, 510.0), 0.5, 4.0)
    with pytest.raises(ValueError, match="not in the mesh"):
        face_gear_mesh(SCENE, teeth=3, refinements={4: patch})
    with pytest.raises(ValueError, match="even"):
        face_gear_mesh(SCENE, divisions=replace(COARSE, fillet=3))
    for wrong in ({"flank": 0}, {"land": 0}, {"across": 0}, {"depth": 0}, {"face_size": -1.0}):
        with pytest.raises(ValueError, match=f"divisions.{next(iter(wrong))} must be"):
            replace(COARSE, **wrong)
    for build in (face_gear_mesh, pinion_mesh):
        with pytest.raises(ValueError, match="one tooth at least"):
            build(SCENE, teeth=0, divisions=COARSE)
    with pytest.raises(ValueError, match="element must be one of"):
        face_gear_mesh(SCENE, element="tet", divisions=COARSE)
    with pytest.raises(ValueError, match="'pinion' or 'gear', not 'wheel'"):
        body_mesh(SCENE, "wheel")
    nan = replace(patch, profile_middle=lambda face: face * np.nan)
    with pytest.raises(MeshError, match="not finite"):
        face_gear_mesh(SCENE, teeth=1, refinements={0: nan})


def test_equal_shares():
    corners = equal_shares(0.0, 10.0, lambda x: 0.1 + 0.3 * x)
    steps = np.diff(corners)
    assert corners[0] == 0.0 and corners[-1] == 10.0
    assert (np.diff(steps) > 0.0).all()
    assert (steps <= 0.1 + 0.3 * corners[1:] + 1e-6).all()
    assert len(equal_shares(0.0, 1.0, np.ones_like, 7)) == 8
    np.testing.assert_allclose(with_middles(np.array([0.0, 1.0, 3.0])), [0.0, 0.5, 1.0, 2.0, 3.0])


@pytest.fixture(scope="module")
def mesh(shipped: sw.Scene) -> ToothMesh:
    divisions = Divisions(flank=8, fillet=4, land=1, across=3, depth=3, face_size=10.0)
    return face_gear_mesh(shipped, teeth=3, divisions=divisions, detailed=(0,))


def worn(depth: float) -> FlankWear:
    """A bump of wear in the middle of the flank."""
    face, profile = np.linspace(480.0, 560.0, 9), np.linspace(-8.0, 7.0, 31)
    values = depth * np.exp(-((profile[:, None] / 3.0) ** 2)) * np.sin(np.pi * (face - 480.0) / 80.0)
    return FlankWear(face, np.broadcast_to(profile[:, None], values.shape), values)


def test_flank_takes_the_wear_and_the_rest_follows(mesh: ToothMesh) -> None:
    wear = worn(0.06)
    moved = moved_flanks(mesh, wear, [0])
    flank = mesh.flanks[0, LOADED]
    shift = (moved.mesh.p - mesh.mesh.p).T
    depth = wear.depth(np.broadcast_to(flank.face, flank.profile.shape), flank.profile)
    assert depth.max() > 0.05
    assert -np.sum(shift[flank.nodes] * flank.normals, axis=-1) == pytest.approx(depth, abs=1e-12)
    assert moved.flanks[0, LOADED].points == pytest.approx(moved.mesh.p.T[flank.nodes], abs=1e-9)
    for still in (mesh.flanks[0, OPPOSITE].nodes, mesh.fillets[0, LOADED].nodes[1:], mesh.held):
        assert shift[still] == pytest.approx(0.0)
    # no node moves farther than the surface, and those below it share the way
    assert np.linalg.norm(shift, axis=1).max() == pytest.approx(depth.max())
    inner = np.setdiff1d(np.arange(len(shift)), flank.nodes)
    assert 0.2 * depth.max() < np.linalg.norm(shift[inner], axis=1).max() < 0.9 * depth.max()
    # the other teeth stay
    assert shift[mesh.flanks[1, LOADED].nodes] == pytest.approx(0.0)


def test_wear_that_folds_elements_is_refused(mesh: ToothMesh) -> None:
    with pytest.raises(MeshError, match="worn gear"):
        moved_flanks(mesh, worn(30.0), [0])
