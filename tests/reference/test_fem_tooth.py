"""Single loaded teeth: convergence of deflection and root stress, and influence data against finite prisms."""

from math import radians

import numpy as np
import pytest
import xarray as xr

from fem_reference.elasticity import ElasticBody
from fem_reference.face_gear_mesh import face_gear_mesh
from fem_reference.influence import OFFSETS, tooth_influence
from fem_reference.pinion_mesh import pinion_mesh
from fem_reference.root_stress import fillet_stress, pressure_load
from fem_reference.solvers import factorise
from fem_reference.tooth_mesh import LOADED, OPPOSITE, Divisions
from semiwear.compliance.prism import prism_section
from semiwear.geometry.involute import InvoluteTooth
from semiwear.scene import load_scene

SCENE = load_scene("face_gear_25x160")
STEEL = {"youngs_modulus": 207000.0, "poissons_ratio": 0.3}


def pressure(profile, face):
    return 60.0 * np.exp(-(((profile - 1.0) / 1.5) ** 2) - ((face - 515.0) / 18.0) ** 2)


def loaded_tooth(divisions, element="hex20"):
    """Work of the load [N mm], deflection of the tip at mid-face [mm] and stress of the fillet of the face gear."""
    mesh = face_gear_mesh(SCENE, element=element, teeth=3, divisions=divisions)
    body = ElasticBody(mesh.mesh, element=element, **STEEL)
    load = pressure_load(body, mesh, pressure)
    free = body.free_dofs(mesh.held)
    moved = np.zeros(body.points.size)
    moved[free] = factorise(body.stiffness[free][:, free]).solve(load[free])
    flank = mesh.flanks[0, LOADED]
    station = int(np.argmin(np.abs(flank.face - 520.0)))
    assert flank.face[station] == pytest.approx(520.0)
    tip = -moved.reshape(-1, 3)[flank.nodes[-1, station]] @ flank.normals[-1, station]
    return load @ moved, tip, fillet_stress(body, mesh, moved), fillet_stress(body, mesh, moved, side=OPPOSITE), load


@pytest.fixture(scope="module")
def fine():
    return loaded_tooth(Divisions(flank=5, fillet=6, land=1, across=4, depth=5, face_size=10.0))


@pytest.mark.slow
def test_converged_within_two_percent(fine):
    coarse = loaded_tooth(Divisions(flank=4, fillet=4, land=1, across=2, depth=4, face_size=10.0))
    print(f"\nwork {coarse[0] / fine[0] - 1:+.2%}, tip {coarse[1] / fine[1] - 1:+.2%}", end="")
    print(f", root stress {coarse[2].greatest / fine[2].greatest - 1:+.2%}")
    assert coarse[1] == pytest.approx(fine[1], rel=0.02)
    assert coarse[2].greatest == pytest.approx(fine[2].greatest, rel=0.02)
    # values of a mesh of 96 thousand unknowns, 12 elements along the fillet
    assert fine[1] == pytest.approx(2.6018e-3, rel=0.02)
    assert fine[2].greatest == pytest.approx(39.86, rel=0.02)


@pytest.mark.slow
def test_loaded_side_is_in_tension(fine):
    _, _, loaded, opposite, _ = fine
    print(f"\nloaded {loaded.stress.min():.1f} to {loaded.greatest:.1f}, opposite {opposite.stress.min():.1f} MPa")
    assert loaded.greatest > 20.0 * abs(loaded.stress.min()) or loaded.stress.min() > 0.0
    assert opposite.stress.min() < -0.5 * loaded.greatest


@pytest.mark.slow
def test_trilinear_elements_agree(fine):
    work, tip, stress, _, _ = loaded_tooth(Divisions(8, 8, 2, 4, 6, 5.0), "hex8i")
    assert tip == pytest.approx(fine[1], rel=0.02)
    assert work == pytest.approx(fine[0], rel=0.03)
    assert stress.greatest == pytest.approx(fine[2].greatest, rel=0.06)


@pytest.mark.parametrize("element", ["hex8i", "hex20", "hex27"])
@pytest.mark.parametrize("build", [face_gear_mesh, pinion_mesh])
def test_constant_pressure_on_both_flanks_loads_up_and_inwards(build, element):
    """The resultant of a pressure is minus the integral of the normal; the two flanks cancel along the arc."""
    mesh = build(SCENE, element=element, teeth=1, divisions=Divisions(4, 2, 1, 2, 2, 20.0))
    body = ElasticBody(mesh.mesh, element=element, **STEEL)
    left, right = (
        pressure_load(body, mesh, lambda p, f: 1.0 + 0.0 * p, side=side).reshape(-1, 3) for side in (LOADED, OPPOSITE)
    )
    flank = mesh.flanks[0, LOADED]
    step = 1 if element == "hex8i" else 2
    corners = flank.points[::step, ::step]
    diagonals = corners[1:, 1:] - corners[:-1, :-1], corners[1:, :-1] - corners[:-1, 1:]
    area = 0.5 * np.cross(*diagonals).sum(axis=(0, 1))
    outward = area * np.sign(area @ flank.normals[len(flank.normals) // 2, flank.normals.shape[1] // 2])
    np.testing.assert_allclose(left.sum(axis=0), -outward, atol=1e-2 * np.linalg.norm(area))
    middle = body.points[mesh.middles[0][0, 0]]
    arc = np.cross([0.0, 1.0, 0.0], middle) if mesh.name == "gear" else np.array([1.0, 0.0, 0.0])
    total = (left + right).sum(axis=0) @ arc / np.linalg.norm(arc)
    assert abs(total) < 1e-6 * np.linalg.norm(area) + (1e-3 if mesh.name == "gear" else 0.0)


@pytest.fixture(scope="module")
def influence():
    return tooth_influence(SCENE, heights=5, stations=5, elements_between_stations=2, fillet_elements=4)


@pytest.mark.slow
def test_influence_is_labelled_and_survives_a_file(influence, tmp_path):
    path = tmp_path / "influence.nc"
    influence.to_netcdf(path)
    with xr.open_dataset(path) as read:
        xr.testing.assert_identical(read.load(), influence)
    assert influence.deflection.dims == (
        "body", "tooth_offset", "observer_height", "observer_station", "height", "station"
    )  # fmt: skip
    assert influence.deflection.attrs["units"] == "mm/N"
    assert influence.attrs["scene_sha256"] == SCENE.sha256
    assert tuple(influence.tooth_offset.values) == OFFSETS
    np.testing.assert_allclose(influence.load_face.sel(body="gear"), np.linspace(480.0, 560.0, 5))


@pytest.mark.slow
def test_influence_is_reciprocal_and_positive(influence):
    assert (influence.asymmetry < 0.05).all()
    own = influence.deflection.sel(tooth_offset=0).values
    for matrix in own.reshape(2, 25, 25):
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * matrix.max())
        assert np.linalg.eigvalsh(matrix)[0] > 0.0


@pytest.mark.slow
@pytest.mark.parametrize(("at", "observed", "tolerance"), [(2, 2, 0.01), (2, 3, 0.03), (1, 1, 0.03)])
def test_influence_agrees_with_the_prism(influence, at, observed, tolerance):
    """Loads on the pinion, whose section does not change: the prism shares neither elements nor method."""
    t = SCENE.gear_pair
    tooth = InvoluteTooth(
        25, 6.35, radians(25.0), t.pinion_addendum_mm, t.rack_addendum_mm, t.rack_tip_radius_mm, 50.0
    )
    prism = prism_section(tooth.section(), width=80.0, heights=5, fillet_elements=8, **STEEL)
    pinion = influence.sel(body="pinion")
    np.testing.assert_allclose(pinion.load_profile, prism.load_profile, atol=1e-6)
    np.testing.assert_allclose(pinion.depth[:, 2], prism.depth, rtol=1e-3)
    wave = np.arange(len(prism.deflection)) * np.pi / 80.0
    spread = np.sinc(wave * 20.0 / (2.0 * np.pi)) ** 2  # linearly to the stations beside, 20 mm away
    both = spread * np.cos(wave * 20.0 * at) * np.cos(wave * 20.0 * observed)
    for k, offset in enumerate(OFFSETS[1:4], start=1):
        found = pinion.deflection.sel(tooth_offset=offset).values[:, observed, :, at]
        expected = np.einsum("n,nij->ij", both, prism.deflection[:, k])
        worst = (np.abs(found - expected) / expected.max())[:4, :4].max()  # at the tip edge the load is too near
        print(f"\ntooth {offset:+d}: deflection against the prism within {worst:.1%} of the greatest", end="")
        assert worst < (tolerance if offset == 0 else 0.08)
    stress = pinion.root_stress.sel(tooth_offset=0).values[:, observed, 3, at].max()
    expected = np.einsum("n,nf->f", both, prism.stress[:, 1, :, 3]).max()
    print(f"\nroot stress against the prism {stress / expected - 1:+.1%}")
    assert stress == pytest.approx(expected, rel=0.05)  # the ends are mirrored here, and this mesh is coarse


def test_sector_stands_for_the_whole_ring():
    """Influence data use a sector of fifteen teeth of the pinion: the ring beyond does not matter."""
    motion = []
    for teeth in (15, None):
        mesh = pinion_mesh(SCENE, teeth=teeth, divisions=Divisions(3, 2, 1, 2, 3, 20.0))
        body = ElasticBody(mesh.mesh, **STEEL)
        load = pressure_load(body, mesh, pressure)
        free = body.free_dofs(mesh.held)
        motion.append(load[free] @ factorise(body.stiffness[free][:, free]).solve(load[free]))
    print(f"\nsector against ring {motion[0] / motion[1] - 1:+.3%}")
    assert motion[0] == pytest.approx(motion[1], rel=5e-4)
