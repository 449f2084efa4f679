"""A face gear's section changes along its face: sections stand close enough, and are blended well enough."""

import numpy as np
import pytest

import semiwear as sw
from semiwear.compliance.block_band import solve_block_band
from semiwear.compliance.elastic_teeth import line_compliance
from semiwear.compliance.tooth import _section_weights
from semiwear.meshing import face_gear_pair
from semiwear.meshing.contact_lines import face_stations, trace_contact_lines
from semiwear.meshing.pairs import flank_pair
from semiwear.plan.teeth import prisms, tooth_compliance, toothed
from semiwear.scene import Placement


@pytest.mark.parametrize("count", [1, 2, 3, 5, 9])
def test_weights_are_of_the_sections_own_places_and_sum_to_one(count: int) -> None:
    faces = np.linspace(480.0, 560.0, count) if count > 1 else np.array([520.0])
    np.testing.assert_allclose(_section_weights(faces, faces), np.eye(count), atol=1e-12)
    at = np.linspace(480.0, 560.0, 41)
    np.testing.assert_allclose(_section_weights(faces, at).sum(axis=-1), 1.0, atol=1e-12)


def test_even_fall_from_section_to_section_is_followed() -> None:
    """A compliance that halves every 20 mm, between sections 13 mm apart: straight lines would be 5 % too high."""
    faces, at = np.linspace(480.0, 560.0, 7), np.linspace(480.0, 560.0, 161)
    blended = _section_weights(faces, at) @ 0.5 ** ((faces - 480.0) / 20.0)
    np.testing.assert_allclose(blended, 0.5 ** ((at - 480.0) / 20.0), rtol=0.006)


@pytest.mark.slow
def test_twice_as_many_sections_give_the_same_deflection(shipped: sw.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Under an even line load, to 2 %, high and low on the flank; it falls to a tenth along the face."""
    scene = shipped.replace({"numerics.harmonics": 5})
    pair = flank_pair(scene.gear_pair, Placement())
    slices, line = np.arange(31), np.zeros(31, dtype=np.int64)

    def deflections() -> list[np.ndarray]:
        prisms.cache_clear()
        toothed.cache_clear()
        lines = trace_contact_lines(pair, np.array([-2.0 / 9.0, 2.0 / 3.0]), face_stations(pair, 31))
        gear = tooth_compliance(scene, pair, lines).bodies[1]
        matrices = [line_compliance((gear,), line + k, slices, line)[0] for k in (0, 1)]
        return [matrix @ lines.length[k] for k, matrix in enumerate(matrices)]

    usual = deflections()
    monkeypatch.setattr(face_gear_pair, "_GEAR_SECTIONS", 2 * face_gear_pair._GEAR_SECTIONS - 1)
    fine = deflections()
    prisms.cache_clear()
    toothed.cache_clear()
    np.testing.assert_allclose(usual, fine, rtol=0.02)


@pytest.mark.parametrize(("count", "below"), [(1, 0), (2, 3), (9, 3)])
def test_blocks_near_the_diagonal_are_solved_as_the_whole_matrix(count: int, below: int) -> None:
    random, size = np.random.default_rng(3), 4
    whole = random.normal(size=(count * size, count * size))
    blocks = (whole + whole.T + 30.0 * np.eye(count * size)).reshape(count, size, count, size).swapaxes(1, 2)
    band = np.zeros((count, below + 1, size, size))
    for k, j in np.ndindex(count, count):
        if 0 <= j - k <= below:
            band[k, j - k] = blocks[j, k]
        elif abs(j - k) > below:
            blocks[j, k] = 0.0
    right = random.normal(size=(count, size, 5))
    wanted = np.linalg.solve(blocks.swapaxes(1, 2).reshape(count * size, -1), right.reshape(count * size, -1))
    found = solve_block_band(band, right.copy())
    np.testing.assert_allclose(found.reshape(count * size, -1), wanted, rtol=1e-11, atol=1e-13)
