"""Elastic mounting: its signs against the geometry of the displaced pair, and what its matrix must be."""

from dataclasses import fields, replace

import numpy as np
import pytest

from semiwear.compliance.mounting import Mounting, MountingSprings, separation_by_freedom
from semiwear.meshing.contact_lines import face_stations, trace_contact_lines
from semiwear.meshing.face_gear_pair import FaceGearMesh
from semiwear.scene import Placement

FREEDOMS = tuple(entry.name for entry in fields(MountingSprings))
# field of the placement, and its unit in mm or rad
PLACEMENT = {
    "offset": ("offset_mm", 1.0),
    "axial_pinion": ("axial_pinion_mm", 1.0),
    "axial_gear": ("axial_gear_mm", 1.0),
    "shaft_angle": ("shaft_angle_error_mrad", 1e-3),
    "pinion_slope": ("pinion_slope_mrad", 1e-3),
}


@pytest.fixture(scope="module")
def on_lines(shipped):
    """The pair, its contact lines, the driven points on them, and the pitch point."""
    pair = FaceGearMesh(shipped.gear_pair, Placement())
    lines = trace_contact_lines(pair, np.array([-0.5, 0.0, 0.6]), face_stations(pair, 15))
    met = pair.meeting(lines.face[None], lines.profile, lines.roll[:, None])
    pitch_point = np.array([0.0, -pair.gear.shaper_pitch_radius, pair.gear.pitch_radius])
    return pair, lines, met, pitch_point


def change_of_separation(pair, name, face, profile, roll):
    """Central difference of the exact separation at fixed driven points by one freedom [mm/mm] or [mm/rad]."""
    key, unit = PLACEMENT[name]
    step = 1e-3
    moved = [replace(pair.placement, **{key: getattr(pair.placement, key) + sign * step}) for sign in (1.0, -1.0)]
    plus, minus = (FaceGearMesh(pair.table, placement).meeting(face, profile, roll).separation for placement in moved)
    return (plus - minus) / (2.0 * step * unit)


@pytest.mark.parametrize("slope", [-1.0, 0.0, 1.0])
@pytest.mark.parametrize("name", FREEDOMS)
def test_separation_changes_as_geometry_says(name, slope, on_lines):
    """Where the pair touches: at radius 508 when aligned, some 10 mm aside when the pinion is tilted by 1 mrad."""
    aligned, _, _, pitch_point = on_lines
    pair = FaceGearMesh(aligned.table, Placement(pinion_slope_mrad=slope))
    roll = np.array([-0.4, 0.0, 0.5])
    lines = trace_contact_lines(pair, roll, face_stations(pair, 401))
    touching = np.argmin(lines.separation[0], axis=1)
    face, profile = lines.face[touching], lines.profile[np.arange(3), touching]
    met = pair.meeting(face, profile, roll)
    found = separation_by_freedom(met.position, met.normal, pitch_point)[:, FREEDOMS.index(name)]
    exact = change_of_separation(pair, name, face, profile, roll)
    # forces on the line of action pass through the pitch point: tilts need a contact aside of it
    arm = 1.0 if PLACEMENT[name][1] == 1.0 else 10.0
    np.testing.assert_allclose(found, exact, rtol=1e-3, atol=1e-3 * arm)
    if name in ("offset", "axial_gear"):
        assert np.all(exact > 0.3)
    elif name != "axial_pinion" and slope != 0.0:
        assert np.all(np.abs(exact) > 0.4 * arm) and np.ptp(exact) < 0.1 * arm


def test_geometry_far_along_the_lines(on_lines):
    """Over all of a line inside the flanks, where the surfaces are apart, normals differ by their slope: 1 %."""
    pair, lines, met, pitch_point = on_lines
    found = separation_by_freedom(met.position, met.normal, pitch_point)
    inside = (lines.profile > lines.low + 0.01) & (lines.profile < lines.high - 0.01)
    assert inside.mean() > 0.5
    for k, name in enumerate(FREEDOMS):
        exact = change_of_separation(pair, name, lines.face[None], lines.profile, lines.roll[:, None])
        error = np.abs(found[..., k] - exact)[inside].max()
        assert error < 0.01 * max(np.abs(exact[inside]).max(), 1.0), name


SPRINGS = MountingSprings(1e-5, 2e-5, 3e-5, 4e-9, 5e-9)


def matrix_of(springs, on_lines):
    _, lines, met, pitch_point = on_lines
    rolls, faces = (part.ravel() for part in np.indices(lines.profile.shape))
    starts = lines.face.size * np.arange(lines.roll.size + 1)
    mounting = Mounting(springs, met.position, met.normal, pitch_point)
    return mounting, (rolls, faces), mounting.matrix((rolls, faces), starts)


def test_matrix_is_symmetric_semidefinite_and_of_rank_five(on_lines):
    _, _, matrix = matrix_of(SPRINGS, on_lines)
    np.testing.assert_array_equal(matrix, matrix.T)
    values = np.linalg.eigvalsh(matrix)
    assert values[0] > -1e-12 * values[-1]
    assert np.linalg.matrix_rank(matrix, hermitian=True, tol=1e-10 * values[-1]) == 5
    assert np.all(np.diag(matrix) > 0.0)
    # every pair shares the mounting
    size = on_lines[1].face.size
    assert np.all(matrix[:size, size:] != 0.0)


@pytest.mark.parametrize("name", FREEDOMS)
def test_one_freedom_gives_rank_one(name, on_lines):
    _, _, matrix = matrix_of(MountingSprings(**{name: 1e-6}), on_lines)
    assert np.linalg.matrix_rank(matrix, hermitian=True, tol=1e-10 * np.abs(matrix).max()) == 1


def test_rigid_mounting_gives_nothing(on_lines):
    assert not matrix_of(MountingSprings(), on_lines)[2].any()


def test_force_pushes_the_pinion_out_of_mesh(on_lines):
    """The displacement under forces, put back as a placement, opens the gap by what the matrix says."""
    pair, lines, _, _ = on_lines
    mounting, at, matrix = matrix_of(SPRINGS, on_lines)
    force = np.zeros(at[0].size)
    middle = lines.face.size + lines.face.size // 2  # roll 0, middle of the face
    force[[middle - 1, middle, middle + 1]] = 1000.0
    moved = mounting.displacement(force, at)
    placement = Placement(
        **{PLACEMENT[name][0]: float(value) / PLACEMENT[name][1] for name, value in zip(FREEDOMS, moved, strict=True)}
    )
    face, profile = lines.face[lines.face.size // 2], lines.profile[1, lines.face.size // 2]
    roll = lines.roll[1]
    opened = FaceGearMesh(pair.table, placement).meeting(face, profile, roll).separation
    opened = opened - pair.meeting(face, profile, roll).separation
    assert opened > 0.0
    assert opened == pytest.approx((matrix @ force)[middle], rel=1e-2)


@pytest.mark.parametrize("name", FREEDOMS)
@pytest.mark.parametrize("value", [-1e-9, float("nan"), float("inf")])
def test_springs_are_checked(name, value):
    with pytest.raises(ValueError, match=name):
        MountingSprings(**{name: value})
