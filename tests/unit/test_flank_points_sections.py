"""Tooth sections drawn after points and a few fields, against those of the pair that the points come from."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import semiwear as sw
from semiwear.compliance.section_mesh import section_mesh
from semiwear.geometry.point_grid import PointGrid
from semiwear.geometry.section import RackRim, RingRim
from semiwear.meshing.pairs import flank_pair
from semiwear.scene import Placement
from tests.scenes import problems_of
from tests.strategies.bevel import BevelPair
from tests.strategies.point_flanks import bevel_scene, exported, scene_of

SPUR = sw.load_scene("spur_fzg_c")
EXACT = flank_pair(SPUR.gear_pair, Placement())


def mean_fillet_radius(fillet: np.ndarray) -> float:
    """Length of a fillet over its turn: the radius of the arc that comes closest."""
    steps = np.diff(fillet, axis=0)
    turn = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    return float(np.linalg.norm(steps, axis=1).sum() / (turn[-1] - turn[0]))


def without_sections(body: str, grid: PointGrid) -> PointGrid:
    return replace(grid, sections=(), attributes={"teeth": grid.attributes["teeth"]})


@pytest.fixture(scope="module")
def data(tmp_path_factory) -> dict[str, Any]:
    """The spur pair as points alone, with the thicknesses and rims of its teeth in the scene."""
    data = exported(SPUR, tmp_path_factory.mktemp("points"), (41, 21), change=without_sections)
    table = data["gear_pair"]
    teeth = (EXACT.pinion, EXACT.gear)
    for index, (body, tooth, working) in enumerate(zip(("pinion", "gear"), teeth, EXACT.working_radii, strict=True)):
        table[f"{body}_tooth_thickness_mm"] = 2.0 * tooth.half_thickness(working)
        # less, so that it fits into the tooth space at the same depth as the trochoid
        fillet = EXACT.prism_body(index).sections[0].fillet
        table[f"{body}_fillet_radius_mm"] = 0.85 * mean_fillet_radius(fillet)
        form = tooth.base_radius * np.hypot(1.0, tooth.form_roll_angle)
        table[f"{body}_root_depth_mm"] = form - tooth.root_radius
        table[f"{body}_rim_thickness_mm"] = tooth.rim_thickness
    return data


def test_a_spur_tooth_is_drawn_as_it_is(data):
    mesh = flank_pair(scene_of(data).gear_pair, Placement())
    for body in (0, 1):
        drawn, exact = mesh.prism_body(body), EXACT.prism_body(body)
        assert len(drawn.sections) == 1
        assert drawn.tooth_length == pytest.approx(exact.tooth_length, rel=1e-6)
        mine, theirs = drawn.sections[0], exact.sections[0]
        assert isinstance(mine.rim, RingRim) and isinstance(theirs.rim, RingRim)
        assert mine.rim.teeth == theirs.rim.teeth
        assert mine.rim.bore_radius == pytest.approx(theirs.rim.bore_radius, rel=1e-4)
        heights = np.hypot(*theirs.flank.T)
        across = np.interp(heights[::-1], np.hypot(*mine.flank.T)[::-1], mine.flank[::-1, 0])[::-1]
        assert across == pytest.approx(theirs.flank[:, 0], abs=5e-3)
        assert np.hypot(*mine.fillet[-1]) == pytest.approx(np.hypot(*theirs.fillet[-1]), abs=1e-3)
        # flank, fillet and root go on without a kink
        corner = np.vstack([mine.flank[-2:], mine.fillet[1:2]])
        turn = np.diff(np.unwrap(np.arctan2(*np.diff(corner, axis=0).T[::-1])))
        assert np.abs(turn).max() < 0.1


@pytest.mark.slow
def test_root_stress_of_drawn_teeth(data):
    """The fillet is an arc instead of a trochoid: root stress within a tenth."""
    coarse = {"face_slices": 11, "roll_positions": 8, "harmonics": 9}
    change = {f"numerics.{name}": value for name, value in coarse.items()}
    stress = [
        sw.loaded_contact(scene.replace(change))["engagement"].root_stress.max(("wear_step", "roll_position")).values
        for scene in (SPUR, scene_of(data))
    ]
    assert stress[1] == pytest.approx(stress[0], rel=0.1)


def test_defaults_need_no_field(data):
    plain = {name: value for name, value in data["gear_pair"].items() if "thickness" not in name}
    plain = {name: value for name, value in plain.items() if "fillet" not in name and "root_depth" not in name}
    mesh = flank_pair(scene_of(data | {"gear_pair": plain}).gear_pair, Placement())
    for body in (0, 1):
        for section in mesh.prism_body(body).sections:
            assert section_mesh(section).nodes.size > 0


def test_a_bevel_gear_is_a_rack_or_virtual_gear(tmp_path):
    """Teeth normal to themselves: the pinion as Tredgold's spur gear of z/(cos delta cos^3 beta) teeth."""
    pair = BevelPair()
    mesh = flank_pair(scene_of(bevel_scene(pair, tmp_path)).gear_pair, Placement())
    pinion, gear = mesh.prism_body(0), mesh.prism_body(1)
    middle = pinion.sections[len(pinion.sections) // 2]
    assert isinstance(middle.rim, RingRim)
    virtual = pair.pinion_teeth / (np.sin(pair.pitch_angle) * np.cos(pair.spiral_angle) ** 3)
    assert middle.rim.teeth == pytest.approx(virtual, rel=0.08)
    for body in (pinion, gear):
        assert body.tooth_length > body.width * 0.98
        assert all(section_mesh(section).nodes.size > 0 for section in body.sections)
    # a gear that is all but flat has more virtual teeth than a ring is worth
    flat = mesh.prism_body(1).sections[0].rim
    assert isinstance(flat, RackRim) or flat.teeth > 3 * pair.gear_teeth


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("tooth_thickness_mm", 13.5),
        ("tooth_thickness_mm", 1.0),
        ("fillet_radius_mm", 9.0),
        ("root_depth_mm", 0.01),
        ("root_depth_mm", 12.0),
        ("rim_thickness_mm", 500.0),
    ],
)
@pytest.mark.parametrize("body", ["pinion", "gear"])
def test_fields_that_leave_no_tooth(data, body, name, value):
    table = data["gear_pair"] | {f"{body}_{name}": value}
    assert next(iter(problems_of(scene_of, data | {"gear_pair": table}))) == f"gear_pair.{body}_{name}"
    # rigid teeth need no section
    scene_of(data | {"gear_pair": table, "numerics": {"tooth_compliance": "rigid"}})


def test_drawn_sections_travel_in_a_file(tmp_path):
    """A bevel pair's own flanks, exported, bring the sections that were drawn for it."""
    scene = scene_of(bevel_scene(BevelPair(), tmp_path))
    folder = tmp_path / "again"
    folder.mkdir()
    again = flank_pair(scene_of(exported(scene, folder, (41, 61))).gear_pair, Placement())
    mesh = flank_pair(scene.gear_pair, Placement())
    for body in (0, 1):
        first, second = mesh.prism_body(body), again.prism_body(body)
        assert second.faces == pytest.approx(first.faces, rel=1e-6)
        assert second.tooth_length == pytest.approx(first.tooth_length)
        for mine, other in zip(first.sections, second.sections, strict=True):
            assert other.flank == pytest.approx(mine.flank)
            assert other.flank_profile == pytest.approx(mine.flank_profile, abs=1e-3)
            assert other.rim == mine.rim
