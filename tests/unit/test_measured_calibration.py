"""`calibrate`: the wear coefficient of simulated parts comes back; lives, comparison, picture and command line."""

import importlib
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest

import semiwear as sw
from semiwear.cli import main
from semiwear.errors import ConvergenceError, SceneError, SemiwearError
from semiwear.geometry.point_grid import PointGrid, write_point_grid
from semiwear.measured.nominal import nominal_flank
from semiwear.measured.predicted import FlankReading, wear_family
from semiwear.measured.rigid import Displacement
from semiwear.meshing.flank_grid import flank_grid
from tests.strategies.measured import displaced, grid_on

pytestmark = pytest.mark.slow

K = 1e-13
MESHES = 5e8
NOISE = 5e-4
COARSE = {
    "numerics.face_slices": 21,
    "numerics.roll_positions": 12,
    "numerics.profile_points": 71,
    "numerics.harmonics": 5,
    "numerics.tooth_compliance": "rigid",
    "wear.until.meshes": MESHES,
    "wear.until.control_depths_um": None,
    "wear.control_point": None,
    "wear.coefficient_mm2_per_N": K,
    "operation.pinion_speed_rpm": 1000.0,
}


@pytest.fixture(scope="module")
def scene(shipped):
    return shipped.replace(COARSE)


@pytest.fixture(scope="module")
def tree(scene):
    """In short steps, so that what steps leave out is small."""
    return sw.simulate(scene.replace({"numerics.wear_steps": 24}))


@pytest.fixture(scope="module")
def grid(scene):
    return grid_on(nominal_flank(scene), 41, 29)


def wear_at(tree, flank, face, profile, step=-1):
    data = tree["flank"].to_dataset()
    depth = 1e-3 * data["wear_depth"].isel(wear_step=step).sel(body="gear").transpose("face", "profile").values
    nodes = flank_grid(flank.pair, data["face"].values, data.sizes["profile"])
    return FlankReading.of(nodes, face.ravel(), profile.ravel()).read(depth).reshape(face.shape)


def part(tree, scene, grid, seed=0, angle=0.3, along=0.01, noise=NOISE, step=-1, times=1.0):
    """Points of a tooth, worn so many times as deep, on a measuring machine: noise, a rotation and a shift."""
    flank = nominal_flank(scene)
    face, profile, *_ = grid
    error = noise * np.random.default_rng(seed).standard_normal(face.shape)
    deviation = error - times * wear_at(tree, flank, face, profile, step)
    return displaced(flank, face, profile, deviation, Displacement.about_axis(angle, along))


@pytest.fixture(scope="module")
def measured(tree, scene, grid):
    return part(tree, scene, grid)


@pytest.fixture(scope="module")
def guess(scene):
    """The scene with a wear coefficient that is 2.3 times too great."""
    return scene.replace({"wear.coefficient_mm2_per_N": 2.3 * K})


@pytest.fixture(scope="module")
def found(guess, measured):
    return sw.calibrate(guess, measured, meshes=MESHES)


def test_the_known_coefficient_lies_in_its_interval(guess, scene, tree, grid, found):
    """Of five measurements at least three: with intervals at 95 % fewer would be one case in a thousand."""
    several = sw.calibrate(guess, [part(tree, scene, grid, seed) for seed in range(5)], meshes=MESHES)
    intervals = np.array([fit.interval(0.95) for fit in several.parts]) * 2.3 * K / MESHES
    assert np.sum((intervals[:, 0] < K) & (intervals[:, 1] > K)) >= 3
    assert several.coefficients[0] == pytest.approx(found.coefficient, rel=1e-6)
    np.testing.assert_allclose(intervals[0], found.interval, rtol=1e-6)
    assert several.interval[0] < K < several.interval[1]
    assert found.coefficient == pytest.approx(K, rel=0.05)
    assert 0.004 < found.log_error < 0.02
    assert found.parts[0].residual_rms == pytest.approx(NOISE, rel=0.1)
    assert found.parts[0].explained > 0.8


def test_twice_the_meshes_are_half_the_coefficient(guess, measured, found):
    other = sw.calibrate(guess, [measured, measured], meshes=[MESHES, 2.0 * MESHES], confidence=0.5)
    assert other.coefficients[0] == pytest.approx(found.coefficient, rel=1e-9)
    assert other.coefficients[1] == pytest.approx(0.5 * found.coefficient, rel=1e-9)


def test_wear_knows_the_coefficient_only_times_the_meshes(scene, tree):
    """What the one run over growing meshes stands on: twice the coefficient for half as long wears the same."""
    changes = {"wear.coefficient_mm2_per_N": 2.0 * K, "wear.until.meshes": 0.5 * MESHES, "numerics.wear_steps": 24}
    other = sw.simulate(scene.replace(changes))
    np.testing.assert_allclose(other["flank"]["wear_depth"], tree["flank"]["wear_depth"], rtol=1e-6, atol=1e-6)


def test_the_first_guess_hardly_matters(scene, measured, found):
    """States of the run lie elsewhere, no more."""
    other = sw.calibrate(scene, measured)
    assert other.coefficient == pytest.approx(found.coefficient, rel=2e-3)


def test_before_and_after(guess, scene, tree, grid, found):
    """Form errors of 3 um that were there before do not count as wear."""
    flank = nominal_flank(scene)
    face, profile, p, f = grid
    form = 3e-3 * np.sin(4.0 * p + 2.0 * f)
    new = displaced(flank, face, profile, form, Displacement.about_axis(-0.2, 0.0))
    worn = displaced(flank, face, profile, form - wear_at(tree, flank, face, profile), Displacement.about_axis(0.4))
    other = sw.calibrate(guess, worn, before=new, meshes=MESHES)
    assert other.coefficient == pytest.approx(K, rel=0.02)
    assert other.log_error < found.log_error


def test_deviations_and_datasets_calibrate_as_well(guess, scene, measured, found):
    wear = sw.measured_wear(scene, measured)
    other = sw.calibrate(guess, [sw.register(scene, measured), wear], meshes=MESHES)
    np.testing.assert_allclose(other.coefficients, found.coefficient, rtol=1e-6)
    with pytest.raises(SceneError, match="known already"):
        sw.calibrate(guess, wear, before=measured, meshes=MESHES)


@pytest.mark.parametrize("height", [200.0, -200.0])
def test_one_point_far_off_does_not_keep_the_flank_from_being_worn_far_enough(guess, scene, measured, found, height):
    """How far to wear is told by the same robust weights; with unit ones it was never far enough."""
    off = sw.measured_wear(scene, measured)
    off["wear_depth"].values[3, 10] += height
    robust = sw.calibrate(guess, off, meshes=MESHES, robust=True)
    assert robust.coefficient == pytest.approx(found.coefficient, rel=0.02)


def test_parts_tell_the_scatter(guess, scene, tree, grid):
    """Three parts of 0.8, 1 and 1.25 times the life at one number of meshes: their k scatter by that."""
    steps = [19, 24, 23]  # of 24
    factors = np.array(steps) / 24.0
    parts = [part(tree, scene, grid, seed=k + 20, step=step) for k, step in enumerate(steps)]
    found = sw.calibrate(guess, parts, meshes=MESHES)
    np.testing.assert_allclose(found.coefficients, factors * K, rtol=0.05)
    logs = np.log(found.coefficients)
    assert found.coefficient == pytest.approx(np.exp(logs.mean()))
    half = 4.302653 * logs.std(ddof=1) / np.sqrt(3.0)  # Student's t of 2 degrees of freedom
    np.testing.assert_allclose(np.log(found.interval), logs.mean() + np.array([-half, half]), rtol=1e-6)
    assert found.k_scatter == pytest.approx(np.sqrt(np.expm1(logs.var(ddof=1))))
    assert "3 parts" in str(found) and str(found).count("arcsec") == 3
    own = found.life(40.0, k_scatter="measured")
    assert own.freedom == 2.0
    assert own.log_deviation == pytest.approx(logs.std(ddof=1) * np.sqrt(4.0 / 3.0))
    dataset = found.to_dataset()
    assert dataset.sizes["part"] == 3
    np.testing.assert_allclose(dataset["part_coefficient"], found.coefficients)


def test_a_part_that_ran_longer_tells_the_same(guess, scene, tree, grid):
    parts = [part(tree, scene, grid, seed=k, step=step) for k, step in ((1, 12), (2, 24))]
    found = sw.calibrate(guess, parts, meshes=[0.5 * MESHES, MESHES])
    np.testing.assert_allclose(found.coefficients, K, rtol=0.06)


def test_the_printed_table(found):
    text = str(found)
    assert f"{found.coefficient:.3e} mm2/N" in text and "95 % interval" in text
    assert "2.300e-13" in text and "rotation" in text
    assert max(map(len, text.splitlines())) <= 120


def test_the_calibrated_scene(found):
    scene = found.calibrated_scene
    assert scene.wear.coefficient("gear") == pytest.approx(found.coefficient)


def test_life_is_inversely_proportional_to_the_coefficient(found):
    """A run of so many meshes with the calibrated coefficient wears to the limit."""
    life = found.life(8.0, k_scatter=0.0)
    scene = found.calibrated_scene.replace({"wear.until.meshes": life.median, "numerics.wear_steps": 6})
    worn = sw.simulate(scene)["flank"]["wear_depth"].isel(wear_step=-1).sel(body="gear")
    assert float(worn.max()) == pytest.approx(8.0, rel=0.03)
    assert life.hours_per_mesh == pytest.approx(160.0 / 25.0 / (60.0 * 1000.0))
    assert " h)" in str(life)


def test_lives_out_of_range_are_refused(found):
    for call, word in (
        (lambda: found.life(0.0), "depth_limit_um"),
        (lambda: found.life(10.0, "pinion"), "body"),
        (lambda: found.life(10.0, k_scatter=-0.1), "k_scatter"),
        (lambda: found.life(10.0, k_scatter="measured"), "three parts"),
        (lambda: found.life(10.0, k_scatter="much"), "k_scatter"),
        (lambda: found.life(10.0).quantile(1.0), "share"),
    ):
        with pytest.raises(SceneError, match=word):
            call()


# ---- both bodies


def test_the_pinion_is_measured_as_well(tree):
    spur = sw.load_scene("spur_fzg_c").replace(
        {"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.harmonics": 3,
         "numerics.profile_points": 61, "wear.until.meshes": 5e7, "numerics.wear_steps": 16,
         "wear.worn_bodies": ["pinion", "gear"], "wear.coefficient_mm2_per_N": {"pinion": K, "gear": 2.0 * K}}
    )  # fmt: skip
    flank = nominal_flank(spur, "pinion")
    face, profile, *_ = grid_on(flank, 41, 9, 0.06)
    worn = sw.simulate(spur)
    depth = worn["flank"]["wear_depth"].isel(wear_step=-1).sel(body="pinion").transpose("face", "profile").values
    nodes = wear_family(spur, "pinion", 1e-3).grid
    wear = 1e-3 * FlankReading.of(nodes, face.ravel(), profile.ravel()).read(depth).reshape(face.shape)
    error = NOISE * np.random.default_rng(0).standard_normal(face.shape)
    points = displaced(flank, face, profile, error - wear, Displacement.about_axis(1.0))
    guess = spur.replace({"wear.coefficient_mm2_per_N": {"pinion": 3.0 * K, "gear": 6.0 * K}})
    found = sw.calibrate(guess, points, body="pinion")
    assert found.interval[0] < K < found.interval[1]
    scaled = found.calibrated_scene.wear
    assert scaled.coefficient("gear") == pytest.approx(2.0 * scaled.coefficient("pinion"))
    assert found.life(20.0).body == "pinion" and found.life(20.0, "gear").body == "gear"
    compared = sw.compare_wear(worn, points, body="pinion")
    assert float(compared["scale"]) == pytest.approx(1.0, abs=0.1)


# ---- comparison and picture


@pytest.fixture(scope="module")
def compared(tree, measured):
    return sw.compare_wear(tree, measured)


def test_comparison_with_what_was_predicted(compared, tree, scene, grid):
    assert float(compared["scale"]) == pytest.approx(1.0, abs=0.03)
    assert float(compared["correlation"]) > 0.95
    assert float(compared["difference_rms"]) == pytest.approx(1e3 * NOISE, rel=0.1)
    apart = compared["predicted"] - compared["wear_depth"]
    np.testing.assert_allclose(compared["difference"], apart, atol=1e-12)
    assert abs(float(compared["difference_max"])) == pytest.approx(float(np.abs(apart).max()))
    expected = 1e3 * wear_at(tree, nominal_flank(scene), *grid[:2])
    # places on the flank move with the datum, by some hundredths of a millimetre; the wear ends steeply at the root
    assert np.sqrt(np.mean((compared["predicted"].values - expected) ** 2)) < 0.1


def test_more_wear_than_predicted_is_a_greater_scale(tree, scene, grid):
    found = sw.compare_wear(tree, part(tree, scene, grid, angle=0.1, along=0.0, noise=0.0, times=1.4))
    assert float(found["scale"]) == pytest.approx(1.4, rel=0.01)
    assert float(found["correlation"]) > 0.99
    assert float(found["difference_max"]) < 0.0  # predicted less than measured


def test_comparison_without_a_datum(tree, scene, grid):
    found = sw.compare_wear(tree, part(tree, scene, grid, angle=0.0, along=0.0, noise=0.0), datum=())
    assert float(np.abs(found["difference"]).max()) < 0.05
    assert float(found["difference_rms"]) < 0.01


def test_results_that_cannot_be_compared_are_told(scene, tree, measured):
    with pytest.raises(SemiwearError, match="wear_depth"):
        sw.compare_wear(sw.loaded_contact(scene), measured)
    with pytest.raises(SceneError, match="wear_step"):
        sw.compare_wear(tree, measured, wear_step=99)
    with pytest.raises(SceneError, match="body"):
        sw.compare_wear(tree, measured, body="wheel")


def test_picture(compared, found):
    for data in (compared, found.comparison()):
        axes = sw.plot.measured_wear(data)
        assert [axis.get_title(loc="left").split(":")[0] for axis in axes] == ["Predicted", "Measured", "Difference"]
        first, second, third = (axis.collections[0].get_clim() for axis in axes)
        assert first == second
        assert third[0] == -third[1]
        axes[0].figure.canvas.draw()
    _, own = plt.subplots(1, 3)
    assert sw.plot.measured_wear(compared, own) == tuple(own)
    with pytest.raises(SemiwearError, match="3 panels"):
        sw.plot.measured_wear(compared, own[:2])
    with pytest.raises(SemiwearError, match="compare_wear"):
        sw.plot.measured_wear(compared.drop_vars("difference"))


def test_every_variable_has_a_unit(compared, scene, measured, found):
    for data in (compared, sw.register(scene, measured), sw.measured_wear(scene, measured), found.comparison()):
        for name, variable in data.data_vars.items():
            assert variable.attrs["units"] and variable.attrs["long_name"], name
            assert np.all(np.isfinite(variable.values)), name
    for name, variable in found.to_dataset().data_vars.items():
        assert variable.attrs["units"], name


# ---- what cannot be calibrated


def refused(word, scene, *arguments, error=SceneError, **options):
    with pytest.raises(error, match=word):
        sw.calibrate(scene, *arguments, **options)


def test_what_cannot_be_calibrated_is_told(scene, guess, measured, shipped, grid, tree):
    refused("confidence", guess, measured, confidence=1.0)
    refused("meshes", shipped, measured)  # it runs to control depths
    refused("meshes: found -1.0; allowed: a number above 0 -> engagements", guess, measured, meshes=-1.0)
    refused("one for each measured part", guess, [measured, measured], meshes=[1e8, 1e8, 1e8])
    refused("as many before", guess, [measured, measured], before=[measured])
    refused("worn_bodies", guess, _pinion_points(scene), body="pinion")
    refused("wear", scene.replace({"wear": None}), measured, meshes=1e8)
    refused(r"measured\[1\]", guess, [measured, measured[:2]])


def _pinion_points(scene):
    flank = nominal_flank(scene, "pinion")
    face, profile, *_ = grid_on(flank, 9, 9)
    return flank.points(face, profile)[0]


def test_an_unworn_flank_says_nothing(guess, scene, tree, grid):
    new = part(tree, scene, grid, step=0)
    refused("does not determine k", guess, new)
    refused("Without before, the unworn flank is assumed nominal", guess, new)


def test_a_flank_worn_away_is_no_wear(guess, scene, grid):
    """A millimetre at the root: no wear of this scene looks like that."""
    flank = nominal_flank(scene)
    face, profile, p, _ = grid
    points = displaced(flank, face, profile, -1.0 * (1.0 - p) ** 2, Displacement.none())
    with pytest.raises((SceneError, ConvergenceError)):
        sw.calibrate(guess, points)


# ---- command line


def test_command_line(guess, measured, found, tmp_path, capsys):
    scene, part_file = tmp_path / "scene.toml", tmp_path / "worn.nc"
    scene.write_text(guess.to_toml(), encoding="utf-8")
    write_point_grid(part_file, PointGrid(measured))
    assert main(["calibrate", str(scene), str(part_file), "--meshes", f"{MESHES:g}", "--life", "40"]) == 0
    told = capsys.readouterr().out
    assert f"{found.coefficient:.3e} mm2/N" in told
    assert "B10" in told and "until 40 um" in told
    assert main(["calibrate", str(scene), str(tmp_path / "none.nc")]) == 2
    assert "no such file" in capsys.readouterr().err


def test_an_exported_worn_flank_is_what_was_predicted(scene, tree, tmp_path):
    """Through a file of points, registration and wear map: nothing is left, but for what lies between the nodes."""
    sw.export_flank(scene, "gear", tmp_path / "worn.nc", points=(61, 41), worn=tree)
    found = sw.compare_wear(tree, tmp_path / "worn.nc", datum=())
    assert float(found["correlation"]) > 0.999
    assert float(found["difference_rms"]) < 0.05


def test_the_progress_ends_with_all_steps_done(monkeypatch):
    """However many are taken of those that might be needed."""
    calibration = importlib.import_module("semiwear.measured.calibration")
    monkeypatch.setattr(calibration, "reading_of", lambda *_: SimpleNamespace(nodes=np.zeros((1, 2))))
    monkeypatch.setattr(calibration, "datum_modes", lambda *_: (None, np.zeros((1, 1))))
    monkeypatch.setattr(calibration, "weighted_meshes", lambda *_: (0.0, None))
    family = SimpleNamespace(extend=lambda: None, greatest=0.01, meshes=[1.0], curve=lambda _: None)
    part = SimpleNamespace(inside=np.array([True]), depth=np.array([1.0]))
    told = []
    heard = SimpleNamespace(step=lambda done, total, _: told.append((done, total)))
    calibration._wear_past(family, [part], (), heard)
    assert told[0][0] == 1 and told[-1] == (3, 3)


def test_a_body_wider_than_its_mate_is_predicted_unworn_beyond_it(spur, tmp_path):
    coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.wear_steps": 1}
    wide = spur.gear_pair.pinion_face_width_mm + 2.0
    scene = spur.replace(coarse | {"gear_pair.gear_face_width_mm": wide})
    path = tmp_path / "worn.csv"
    tree = sw.simulate(scene)
    sw.export_flank(scene, "gear", path, points=(21, 9), worn=tree)
    compared = sw.compare_wear(tree, path)
    assert not compared.predicted.isel(face=[0, -1]).values.any()
    assert compared.difference_max < 0.1 * compared.predicted.max()
