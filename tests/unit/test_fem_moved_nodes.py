"""A worn gear mesh by moved nodes."""

from __future__ import annotations

import numpy as np
import pytest

import semiwear as sw
from fem_reference.face_gear_mesh import face_gear_mesh
from fem_reference.hexahedra import MeshError
from fem_reference.moved_nodes import moved_flanks
from fem_reference.pitch_blocks import Divisions
from fem_reference.tooth_mesh import LOADED, OPPOSITE, ToothMesh
from fem_reference.wear import FlankWear


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
