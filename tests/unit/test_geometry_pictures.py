"""Pictures of teeth: both bodies touch at the pitch point, and the path ends on their tips."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import semiwear as sw
from semiwear.cli import main
from semiwear.geometry.cylindrical import CylindricalTooth
from semiwear.plot import geometry_figure, path_on_flank, teeth_in_mesh, tooth_sections

RING = {"gear_pair.gear_teeth": -60, "gear_pair.pinion_teeth": 20, "gear_pair.centre_distance_mm": None}
RING |= {"gear_pair.pinion_profile_shift": 0.0, "gear_pair.gear_profile_shift": 0.0}
CHANGES = {
    "spur": ("spur_fzg_c", {}),
    "coast": ("spur_fzg_c", {"operation.loaded_flank": "coast"}),
    "helical": ("spur_fzg_c", {"gear_pair.helix_angle_deg": 20.0, "gear_pair.centre_distance_mm": None}),
    "internal": ("spur_fzg_c", RING),
    "face gear": ("face_gear_25x160", {}),
}


def scene_of(case):
    name, changes = CHANGES[case]
    return sw.load_scene(name).replace(changes)


def curves(ax, least=200):
    return [line.get_xydata() for line in ax.get_lines() if len(line.get_xydata()) > least]


@pytest.mark.parametrize("case", CHANGES)
def test_teeth_touch_at_the_pitch_point_and_do_not_cross(case):
    scene = scene_of(case)
    _, given = plt.subplots()
    assert teeth_in_mesh(scene, given) is given
    pinion, gear = curves(given)
    module = getattr(scene.gear_pair, "normal_module_mm", None) or scene.gear_pair.module_mm
    for outline in (pinion, gear):
        assert np.hypot(*outline.T).min() < 0.02 * module
    # near the pitch point the pinion's flank stays on its side of the gear's
    side = -1.0 if case == "coast" else 1.0
    near = [outline[np.abs(outline[:, 1]) < 0.6 * module] for outline in (pinion, gear)]
    near = [outline[np.abs(outline[:, 0]) < 0.45 * module] for outline in near]
    across = [np.interp(0.3 * module * np.array([-1, 1]), *(o[np.argsort(o[:, 1])].T[::-1])) for o in near]
    assert np.all(side * (across[0] - across[1]) > -0.01 * module)


def test_the_path_of_contact_is_that_of_the_analysis():
    scene = scene_of("spur")
    ax = teeth_in_mesh(scene)
    path = next(line for line in ax.get_lines() if line.get_linewidth() == 2.2).get_xydata()
    analysis = sw.tooth_contact_analysis(scene)
    found = analysis.path_of_contact.values[[0, -1], :2]
    found = found - np.array([0.0, -0.5 * 91.5 * 16 / 40 * 2])
    assert np.allclose(sorted(path.tolist()), sorted(found.tolist()), atol=0.05)


@pytest.mark.parametrize("teeth", [16, -60])
@pytest.mark.parametrize("helix", [0.0, 0.4])
def test_the_transverse_outline_has_the_tooth_thickness(teeth, helix):
    internal = teeth < 0
    reference = 0.5 * 4.5 * abs(teeth) / np.cos(helix)
    side = -1.0 if internal else 1.0
    tooth = CylindricalTooth(
        abs(teeth), internal, 4.5, np.radians(20.0), helix, 0.1, reference + side * 4.0, 5.625, 1.0, 12.0
    )
    outline = tooth.transverse_outline()
    assert outline[0, 0] == pytest.approx(tooth.tip_radius)
    assert outline[-1].tolist() == pytest.approx([tooth.root_radius, np.pi / abs(teeth)])
    flank = outline[:81]
    expected = [tooth.half_thickness(radius) / radius for radius in flank[:, 0]]
    assert np.allclose(flank[:, 1], expected, atol=1e-9)
    assert np.all(np.diff(outline[:, 1]) > -1e-12) or tooth.form_roll_angle < 0.35
    assert np.all(side * np.diff(outline[:, 0]) < 1e-9)


def test_sections_of_a_face_gear_stand_on_one_pitch_plane():
    ax = tooth_sections(scene_of("face gear"))
    sections = curves(ax, least=50)
    assert len(sections) >= 5
    for section in sections:
        assert section[:, 1].max() == pytest.approx(6.35, abs=1e-6)
        assert section[:, 1].min() == pytest.approx(-7.9375, abs=1e-6)
    widths = [np.ptp(section[section[:, 1] > 6.3, 0]) for section in sections]
    assert widths == sorted(widths, reverse=True)  # it points towards the outer radius


@pytest.mark.parametrize("case", ["spur", "face gear"])
def test_every_picture_of_a_kind_is_drawn(case, tmp_path):
    scene = scene_of(case)
    assert len(geometry_figure(scene).axes) == (1 if case == "spur" else 3)
    _, given = plt.subplots()
    assert path_on_flank(scene, given) is given
    assert tooth_sections(scene, "pinion", given) is given


def test_a_picture_is_saved(tmp_path):
    path = tmp_path / "teeth.svg"
    assert main(["geometry", "spur_fzg_c", "-o", str(path)]) == 0
    assert "<svg" in path.read_text(encoding="utf-8")
    assert main(["geometry", "spur_fzg_c", "-o", str(tmp_path / "teeth.toml")]) == 2


@pytest.mark.slow
def test_flanks_as_points_are_drawn(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "flank_points", "-o", "mine.toml"]) == 0
    assert main(["geometry", "mine.toml", "-o", "mine.svg"]) == 0
    assert main(["check", "mine.toml"]) == 0
    with pytest.raises(sw.SemiwearError, match="tooth_sections"):
        teeth_in_mesh(sw.load_scene("mine.toml"))
