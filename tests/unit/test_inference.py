"""Inference: closed forms, what is refused, what is told; solving is made up but for the slow tests."""

from importlib import import_module

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from scipy.interpolate import CubicSpline

import semiwear as sw
from semiwear.cli import main
from semiwear.errors import ConvergenceError, EndlessWearError, SceneError, SemiwearError
from semiwear.geometry.point_grid import PointGrid, write_point_grid
from semiwear.inference.apart import undetermined_fields
from semiwear.inference.observations import _without_holes
from semiwear.inference.page import _draw_life
from semiwear.inference.run import _same_levels, plan_inference
from semiwear.inference.unknowns import CUT, Unknown
from semiwear.measured.comparison import grid_of
from semiwear.measured.nominal import nominal_flank
from semiwear.measured.predicted import FlankReading
from semiwear.measured.quantities import labelled
from semiwear.measured.rigid import Displacement
from semiwear.plot.posterior import posterior_corner
from semiwear.plot.style import styled
from semiwear.sweep.measure import Measured
from tests.scenes import SHIPPED, TINY, UNTIL_MESHES
from tests.strategies.measured import displaced, grid_on

outcome = import_module("semiwear.sweep.outcome")
K, TORQUE, OFFSET = "wear.coefficient_mm2_per_N", "operation.pinion_torque_Nm", "effects.misalignment.offset_mm"
SPEED = "operation.pinion_speed_rpm"
MESHES = 1e8
SCENE = SHIPPED.replace({**TINY, **UNTIL_MESHES, "wear.until.meshes": MESHES, K: 1e-13})
SPUR = sw.load_scene("spur_fzg_c")
COEFFICIENT = sw.LogNormal(1e-13, 0.5)
FACE = np.linspace(485.0, 555.0, 11)


def depth_of(torque: float, offset: float, meshes: np.ndarray) -> np.ndarray:
    """Greatest wear [um] by a formula: k times torque times meshes, less where the pinion is offset."""
    return 10.0 * meshes / MESHES * torque / 1600.0 * (1.0 - 2.0 * offset)


@pytest.fixture
def solved(monkeypatch):
    """Runs by formulas: depth times a fixed shape of the flank, transmission error with a wave that wear deepens."""
    scenes = []

    def simulate(scene):
        scenes.append(scene)
        misaligned = scene.effects.misalignment
        meshes = np.linspace(0.0, scene.wear.until.meshes, scene.numerics.wear_steps + 1)
        offset = misaligned.offset_mm if misaligned else 0.0
        depth = depth_of(scene.operation.pinion_torque_Nm, offset, meshes)
        shape = np.linspace(1.0, 0.0, 31)[:, None] * np.linspace(1.0, 0.5, 11)
        phase = np.arange(8) / 8.0
        curve = (2.0 + 0.3 * depth)[:, None] * np.sin(2.0 * np.pi * phase) + 100.0
        wear = np.stack([np.zeros((meshes.size, 31, 11)), depth[:, None, None] * shape], axis=1)
        steps = {"meshes": ("wear_step", meshes)}
        amplitude = ("wear_step", np.ptp(curve, axis=1))
        return xr.DataTree.from_dict(
            {
                "/history": xr.Dataset({"transmission_error_amplitude": amplitude}, steps),
                "/flank": xr.Dataset(
                    {"wear_depth": (("wear_step", "body", "profile", "face"), wear)},
                    {"body": ["pinion", "gear"], "face": FACE, "profile": np.arange(31)},
                ),
                "/mesh_cycle": xr.Dataset(
                    {"transmission_error_loaded": (("wear_step", "mesh_position"), curve)}, {"mesh_position": phase}
                ),
            }
        )

    monkeypatch.setattr(outcome, "simulate", simulate)
    monkeypatch.setattr(outcome, "simulate_as_given", lambda scene, **_: outcome.simulate(scene))
    return scenes


@pytest.fixture
def short(monkeypatch):
    """Chains of a twentieth of the steps: enough where no more is asked of draws than a range."""
    monkeypatch.setattr(import_module("semiwear.inference.sampling"), "_BLOCK", 20)


def amplitude(depth: float, error: float, **options: float) -> sw.Reading:
    return sw.Reading("transmission_error_amplitude", 2.0 * (2.0 + 0.3 * depth), error, **options)


def infer(unknown, observed, **options):
    return sw.infer(SCENE, unknown, observed, crew=0, **options)


# ---------------------------------------------------------------------- closed forms


def test_one_reading_of_the_coefficient_alone_is_the_normal_posterior(solved):
    """Depth 8 +- 0.16 um tells k times 1e13 as 0.8 +- 0.016, the prior hardly anything beside it: in one run."""
    found = infer({K: sw.Uniform(2e-14, 2e-13)}, amplitude(8.0, 0.6 * 0.16))
    assert len(solved) == 1
    draws = found.of(K) * 1e13
    assert draws.mean() == pytest.approx(0.8, abs=0.002) and draws.std() == pytest.approx(0.016, rel=0.08)
    assert found.interval(K) == pytest.approx((0.8e-13 - 1.96 * 1.6e-15, 0.8e-13 + 1.96 * 1.6e-15), rel=5e-3)
    assert found.not_told_apart == () and found.draws.settled


def test_a_reading_that_says_nothing_leaves_the_prior(solved):
    found = infer({K: COEFFICIENT, TORQUE: sw.Normal(1600, 100)}, amplitude(8.0, 1e3))
    scatter = 4.0 / np.sqrt(2.0 * found.draws.effective)  # four standard errors of a deviation from so many draws
    assert scatter < 0.15
    assert np.std(np.log(found.of(K))) == pytest.approx(np.sqrt(np.log(1.25)), rel=scatter)
    assert found.of(TORQUE).std() == pytest.approx(100.0, rel=scatter)
    assert len(found.not_told_apart) == 2 and all("hardly determined" in line for line in found.not_told_apart)


def test_coefficient_and_torque_that_appear_as_a_product_are_told_as_such(solved, short):
    found = infer({K: COEFFICIENT, TORQUE: sw.Normal(1600, 200)}, amplitude(8.0, 0.02))
    product = found.of(K) * found.of(TORQUE)
    assert product.std() / product.mean() < 0.01 and found.of(TORQUE).std() / 1600.0 > 0.08
    told = "\n".join(found.not_told_apart)
    assert "cannot be distinguished" in told and "pinion_torque_Nm^1.0" in told
    assert told in str(found).replace("\n    ", " ") or "cannot be distinguished" in str(found)


def test_an_unworn_reading_says_nothing_of_wear(solved):
    """Its amplitude is that of unworn flanks for any k."""
    found = infer({K: COEFFICIENT}, amplitude(0.0, 0.01, meshes=0))
    assert found.shares_of_prior[0] == pytest.approx(1.0, abs=0.06)


def test_points_and_a_curve_tell_together(solved, short):
    """k, torque and offset: a curve of a mean that is open, and points of the flank, of twice the meshes."""
    k, torque = 1.2e-13, 1700.0
    depth = float(depth_of(torque, 0.0, np.array(MESHES * 1.2)))
    phase = np.array([0.0, 0.25, 0.5, 0.75])
    curve = sw.TransmissionErrorCurve(phase, (2.0 + 0.3 * depth) * np.sin(2.0 * np.pi * phase) - 7.0, 0.02)
    flank = nominal_flank(SCENE)
    face, profile = flank.places(np.array([0.2, 0.5, 0.8]), np.array([0.3, 0.3, 0.6]))
    height, _ = flank.place(face, profile)
    grid = grid_of(SCENE, FACE, 31, "gear")
    shape = np.linspace(1.0, 0.0, 31)[:, None] * np.linspace(1.0, 0.5, 11)
    wear = 2.0 * depth * FlankReading.of(grid, face, profile).read(shape.T)
    points = sw.WearAtPoints(face, height, wear, 0.05, meshes=2.0 * MESHES)
    found = infer({K: COEFFICIENT, TORQUE: sw.Normal(1600, 100)}, [curve, points])
    low, high = np.quantile(found.of(K) * found.of(TORQUE), [0.001, 0.999])
    assert low < k * torque < high and high / low < 1.1
    assert [round(misfit) for _, _, misfit in found.fitted()] in ([0, 0], [0, 1], [1, 0], [1, 1])


def test_life_is_inverse_to_the_coefficient(solved, short, monkeypatch):
    """The life at every draw: of the formula, emulated over torque, and inverse to k."""

    def life(task):
        scene = task.scene
        meshes = MESHES * scene.effects.run_life.depth_limit_um / 10.0 * 1600.0 / scene.operation.pinion_torque_Nm
        return Measured({"/life/meshes_to_limit": np.array(meshes), "/life/depth_limit": np.array(20.0)})

    monkeypatch.setattr(outcome, "_life", life)
    found = infer({K: COEFFICIENT, TORQUE: sw.Normal(1600, 100)}, amplitude(8.0, 0.05))
    lives = found.life(20.0, crew=0)
    expected = MESHES * 2.0 * 1600.0 / found.of(TORQUE) * 1e-13 / found.of(K)
    np.testing.assert_allclose(lives.meshes, expected, rtol=1e-3)
    assert lives.error < 1e-3 and "of this pair" in str(lives)
    next_part = found.life(20.0, crew=0, k_scatter=0.5)
    spread = np.std(np.log(next_part.meshes / expected))
    assert spread == pytest.approx(np.sqrt(2.0 * np.log(1.25)), rel=0.05)
    assert lives.quantile(0.1) < lives.quantile(0.5)
    for call in (lambda: found.life(20.0, k_scatter=-1), lambda: found.life(20.0, runs=3), lambda: lives.quantile(1)):
        with pytest.raises(SceneError):
            call()


@pytest.mark.parametrize("unknown", [{SPEED: sw.Uniform(500, 3000)}, {}])
def test_hours_of_a_life_are_at_the_speed_of_each_draw(solved, short, monkeypatch, unknown):
    """A speed that wear does not know: meshes are those of the coefficient, hours those over each draw's speed."""

    def life(task):
        meshes, speed = MESHES * 2.0, task.scene.operation.pinion_speed_rpm
        hours = meshes * 6.4 / (60.0 * speed)
        return Measured({f"/life/{name}": np.array(value) for name, value in (
            ("meshes_to_limit", meshes), ("hours_to_limit", hours), ("depth_limit", 20.0)
        )})  # fmt: skip

    monkeypatch.setattr(outcome, "_life", life)
    scene = SCENE.replace({SPEED: 1000.0})
    found = sw.infer(scene, {K: COEFFICIENT, **unknown}, amplitude(8.0, 0.05), crew=0)
    lives = found.life(20.0, crew=0)
    speed = found.of(SPEED) if unknown else 1000.0
    hours = lives.meshes * 6.4 / (60.0 * speed)
    np.testing.assert_allclose(lives.meshes * lives.hours_per_mesh, hours)
    assert lives.hours(0.1) == pytest.approx(np.quantile(hours, 0.1))
    assert f"meshes ({np.quantile(hours, 0.5):.4g} h)" in str(lives)
    with pytest.raises(SceneError, match="share"):
        lives.hours(1.0)


def test_lives_without_end_outlive_all_others(solved, short, monkeypatch):
    """Half of the torques wear no further before the depth: so many lives are infinite, the others as they were."""

    def life(task):
        torque = task.scene.operation.pinion_torque_Nm
        if torque < 1600.0:
            raise EndlessWearError("the gear wears no further", life=True)
        return Measured({"/life/meshes_to_limit": np.array(MESHES * 1600.0 / torque)})

    monkeypatch.setattr(outcome, "_life", life)
    found = infer({TORQUE: sw.Normal(1600, 100)}, amplitude(8.0, 1e3))
    lives = found.life(20.0, crew=0, runs=64)
    finite = np.isfinite(lives.meshes)
    assert lives.meshes.size == 64 and 0.3 < finite.mean() < 0.7
    torques = found.of(TORQUE)
    np.testing.assert_allclose(np.quantile(torques, 0.9), 1600.0 * MESHES / lives.quantile(0.1), rtol=0.02)
    assert lives.quantile(0.9) == np.inf
    assert f"of 64 solved lives {64 - finite.sum()} have no end" in str(lives) and "B90 without end" in str(lives)
    with styled():
        _draw_life(lives, [Figure().subplots()])
    with pytest.raises(SemiwearError, match="32 of 32 lives cannot be found: the gear wears no further"):
        infer({TORQUE: sw.Uniform(1000, 1590)}, amplitude(8.0, 1e3)).life(20.0, crew=0)


# ---------------------------------------------------------------------- parts


def test_holes_are_left_out_by_rows_and_columns():
    inside = np.ones((6, 5), dtype=bool)
    inside[0] = inside[3, 2] = False
    rows, columns = _without_holes(inside)
    assert inside[np.ix_(rows, columns)].all() and rows.sum() * columns.sum() == 20


@pytest.mark.parametrize("prior", [sw.LogNormal(1e-13, 0.5), sw.Normal(0.0, 0.05), sw.Uniform(1.0, 3.0)])
def test_places_and_values_of_a_prior(prior):
    one = Unknown("a.b", prior)
    values = one.values(np.linspace(-8.0, 8.0, 9))
    np.testing.assert_allclose(values[[0, -1]], one.ends, rtol=1e-6)
    np.testing.assert_allclose(one.at(one.places(values)), values, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(prior.quantile(np.array([CUT]))[0], one.ends[0])


def test_fields_that_go_together_by_differences():
    random = np.random.default_rng(0)
    first = random.standard_normal(500)
    pair = [Unknown("x.offset_mm", sw.Normal(0, 1)), Unknown("x.angle_mrad", sw.Normal(0, 1))]
    values = np.column_stack([first, -first + 0.1 * random.standard_normal(500)])
    (line,) = undetermined_fields(pair, values, np.array([0.5, 0.5]))
    assert "together, not singly" in line and "-1.00" in line and "mm" in line


# ---------------------------------------------------------------------- refused


@pytest.mark.parametrize(
    "unknown, observed, options, parts",
    [
        ({}, amplitude(8, 1), {}, ["a mapping from dotted keys"]),
        ([K], amplitude(8, 1), {}, ["a mapping from dotted keys"]),
        (None, amplitude(8, 1), {}, ["a mapping from dotted keys"]),
        ({"operation.torque": sw.Normal(9, 1)}, [], {}, ["did you mean pinion_torque_Nm", "one observation or more"]),
        ({K: 3}, "worn.nc", {"runs": 3}, ["Normal, LogNormal", "goes into WornFlank", "32 to 4096"]),
        ({K: COEFFICIENT}, sw.Reading("wear_depth", 1, 1), {}, ["did you mean"]),
        ({K: COEFFICIENT}, sw.Reading("transmission_error_mean[worst]", 1, 1), {}, ["without a time"]),
        ({K: COEFFICIENT}, sw.Reading("transmission_error_mean", 1, -1.0), {}, ["uncertainty"]),
        ({K: COEFFICIENT}, sw.WornFlank("nothing.nc", body="pinion"), {}, ["wear.worn_bodies"]),
        ({K: COEFFICIENT}, sw.WornFlank("nothing.nc"), {"emulator_share": 0.0}, ["no such file", "0.3 is usual"]),
        ({K: COEFFICIENT}, sw.WearAtPoints([400], [0], [1], 1), {}, ["a coordinate along the face"]),
        ({K: COEFFICIENT}, sw.WearAtPoints([500], [50], [1], 1), {}, ["height above the pitch surface"]),
        ({K: COEFFICIENT}, sw.WearAtPoints([500, 510], [0, 0], [1, 2, 3], 1), {}, ["2 finite numbers"]),
        ({K: COEFFICIENT}, sw.TransmissionErrorCurve([0, 0.5], [1, 2], 1), {}, ["three or more"]),
        ({K: COEFFICIENT}, amplitude(8, 1, meshes=-1), {}, ["0 or more"]),
        ({"wear.until.meshes": sw.Uniform(1e7, 1e9)}, amplitude(8, 1), {}, ["infer the wear coefficient"]),
        ({"numerics.wear_steps": sw.Uniform(8, 40)}, amplitude(8, 1), {}, ["a field that no run sets"]),
    ],
)
def test_everything_wrong_is_told_before_anything_runs(solved, unknown, observed, options, parts):
    with pytest.raises(SceneError) as error:
        infer(unknown, observed, **options)
    for part in parts:
        assert part in str(error.value)
    assert not solved


def test_hours_at_an_unknown_speed_are_no_meshes(solved):
    scene = SCENE.replace({"operation.pinion_speed_rpm": 100.0, "wear.until.hours": 1000.0})
    unknown = {K: COEFFICIENT, "operation.pinion_speed_rpm": sw.Uniform(80.0, 120.0)}
    readings = [sw.Reading("wear_depth_max[gear]", 8.0, 1.0, meshes=meshes) for meshes in (None, 1e6)]
    with pytest.raises(SceneError, match=r"observed\[0\].meshes: missing.*an unknown") as error:
        sw.infer(scene, unknown, readings)
    assert "observed[1]" not in str(error.value)
    assert not solved


def test_a_flank_without_any_noise_is_refused(solved):
    """How far to rely on depths is told from their noise, which a flank of zeros has not."""
    flank = nominal_flank(SCENE)
    face, profile, *_ = grid_on(flank, 25, 15)
    values = {"wear_depth": np.zeros(face.shape), "flank_profile": profile, "flank_face": face}
    even = labelled(values | {"inside": np.ones(face.shape, dtype=bool)}, {"body": "gear"}, "even")
    with pytest.raises(SceneError, match="the same depth at every point"):
        infer({K: COEFFICIENT}, sw.WornFlank(even))
    assert not solved


def test_runs_with_wear_states_of_their_own_are_refused():
    """Amounts are interpolated over the meshes of all runs: those of one would be wrong for the others."""
    levels = np.linspace(0.0, 1e8, 5)
    np.testing.assert_array_equal(_same_levels([levels, levels * (1.0 + 1e-14)]), levels)
    for other in (1.1 * levels, levels[:4]):
        with pytest.raises(SemiwearError, match="different meshes"):
            _same_levels([levels, other])


@pytest.mark.parametrize(("scene", "datum"), [(SCENE, ()), (SPUR, ("axial",)), (SPUR, ("rotation",))])
def test_a_flank_of_no_or_of_any_datum_is_read(scene, datum):
    """No motion is left open; or one that a spur flank cannot tell; or one that it can."""
    flank = nominal_flank(scene)
    face, profile, *_ = grid_on(flank, 13, 9)
    depth = np.random.default_rng(0).standard_normal(face.shape)
    values = {"wear_depth": depth, "flank_profile": profile, "flank_face": face, "inside": np.ones(face.shape, bool)}
    worn = sw.WornFlank(labelled(values, {"body": "gear"}, "worn"), meshes=MESHES, datum=datum)
    (channel,) = plan_inference(scene, {K: COEFFICIENT}, worn).channels
    assert channel.movements.shape == (face.size, 1 if datum == ("rotation",) else 0)
    assert np.isfinite(channel.evidence(profile.reshape(-1, 1)).centres).all()


def test_an_emulator_that_stays_too_rough_is_refused(solved, short, monkeypatch):
    """Runs that scatter by far more than the measurement's error."""
    simulate, rough = outcome.simulate, np.random.default_rng(0)

    def noisy(scene):
        tree = simulate(scene)
        history = tree["history"].to_dataset()
        factor = 1.0 + 0.2 * rough.standard_normal()
        tree["history"] = xr.DataTree(
            history.assign(transmission_error_amplitude=history["transmission_error_amplitude"] * factor)
        )
        return tree

    monkeypatch.setattr(outcome, "simulate", noisy)
    monkeypatch.setattr(import_module("semiwear.inference.run"), "_GROWTH", 1)
    with pytest.raises(SemiwearError, match="after 64 runs the emulator's error still is"):
        infer({K: COEFFICIENT, TORQUE: sw.Normal(1600, 100)}, amplitude(8.0, 0.001), emulator_share=0.05)


def test_a_field_that_was_not_inferred_is_told(solved, short):
    found = infer({K: COEFFICIENT}, amplitude(8.0, 0.1))
    with pytest.raises(SemiwearError, match="did you mean"):
        found.of("coefficient_mm2")
    with pytest.raises(SceneError, match="share"):
        found.quantile(K, 0.0)


def test_fields_of_one_name_are_told_apart(solved, short):
    """Crowning of both bodies: each has its draws, and a name of its own."""
    crowning = [f"effects.modification.{body}.crowning_um" for body in ("pinion", "gear")]
    found = infer({key: sw.Uniform(1.0 + k, 1.5 + k) for k, key in enumerate(crowning)}, amplitude(10.0, 0.5))
    data = found.to_dataset()
    assert set(data.data_vars) == {"pinion_crowning_um", "gear_crowning_um"}
    for name, key in zip(("pinion_crowning_um", "gear_crowning_um"), crowning, strict=True):
        np.testing.assert_array_equal(found.of(name), found.of(key))
        np.testing.assert_array_equal(data[name], found.of(key))
    assert found.of(crowning[0]).max() < 1.5 < 2.0 < found.of(crowning[1]).min()
    with pytest.raises(
        SemiwearError, match=r"last part of .*pinion\.crowning_um and of .*gear\.crowning_um: give one"
    ):
        found.of("crowning_um")


# ---------------------------------------------------------------------- command line, page


STUDY = f"""
scene = "scene.toml"
[unknown]
{K} = {{distribution = "lognormal"}}
{TORQUE} = {{distribution = "normal", mean = 1600, deviation = 100}}
[[reading]]
quantity = "transmission_error_amplitude"
value = 8.8
error = 0.05
[[transmission_error]]
file = "curve.csv"
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The folder of a study, with its scene; paths begin there."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE.to_toml())
    return tmp_path


def test_a_study_file(solved, short, unseen, folder, capsys):
    (folder / "study.toml").write_text(STUDY)
    lines = [f"{x},{4.4 * np.sin(2 * np.pi * x)},0.1" for x in (0.0, 0.25, 0.5, 0.75)]
    (folder / "curve.csv").write_text("\n".join(["mesh_position,error_arcsec,uncertainty_arcsec", *lines]))
    assert main(["infer", "study.toml", "-o", "draws.nc", "--workers", "0", "--report", "page.html"]) == 0
    told = capsys.readouterr().out
    assert "cannot be distinguished" in told and "page.html" in told
    with xr.open_dataset("draws.nc") as draws:
        assert draws["pinion_torque_Nm"].attrs["field"] == TORQUE and draws.sizes["draw"] > 1000
        axes = posterior_corner(draws)
        assert len(axes) == 4 and not axes[1].get_visible()
    page = (folder / "page.html").read_text()
    for part in ("Undetermined fields", "Transmission error at 4 mesh positions", "scene SHA-256"):
        assert part in page


def test_a_study_file_tells_all_its_problems(solved, folder, capsys):
    bad = STUDY.replace("value = 8.8\n", "valu = 8.8\n").replace("scene =", "life_um = [0]\nscene =", 1)
    bad = bad.replace(TORQUE, "operation.pinion_torq", 1)
    (folder / "study.toml").write_text(bad + f"[vary]\n{TORQUE} = [1]\n")
    assert main(["infer", "study.toml", "-o", "draws.txt", "--report", "away/page.html"]) == 2
    told = capsys.readouterr().err
    for part in (
        "draws.txt",
        "a folder that exists",
        "did you mean value?",
        "reading[0].value: missing",
        "curve.csv",
        "life_um",
        "[vary]",
        "did you mean pinion_torque_Nm?",
    ):
        assert part in told
    assert not solved


def test_what_needs_no_scene_is_told_beside_one_that_cannot_be_read(solved, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    bad = STUDY.replace("value = 8.8\n", "valu = 8.8\n").replace("scene =", "runs = 3\nk_scatter = -9\nscene =", 1)
    misspelt = 'operation.pinion_torqe_Nm = {distribution = "norml"}'
    bad = bad.replace("[unknown]", f"[unknown]\nnumerics.harmonics = 3\n{misspelt}", 1)
    (tmp_path / "study.toml").write_text(bad + f"[vary]\n{TORQUE} = [1]\n")
    assert main(["infer", "study.toml", "-o", "draws.nc"]) == 2
    told = capsys.readouterr().err
    for part in (
        "no file 'scene.toml'",
        "runs: found 3",
        "k_scatter: found -9",
        "did you mean value?",
        "curve.csv",
        "numerics.harmonics: found 'an unknown field'",
        "did you mean pinion_torque_Nm?",
        'did you mean "normal"?',
        "[vary]",
    ):
        assert part in told
    assert not solved


@pytest.mark.parametrize("table, found", [("", "{}"), ("unknown = 3\n", "3"), ("[unknown]\n", "{}")])
def test_unknown_fields_that_are_missing_are_told_by_their_table(solved, tmp_path, capsys, table, found):
    for scene in ("spur_fzg_c", "no_such_scene"):
        (tmp_path / "study.toml").write_text(f'runs = 3\nscene = "{scene}"\n{table}')
        assert main(["infer", str(tmp_path / "study.toml"), "-o", str(tmp_path / "draws.nc")]) == 2
        told = capsys.readouterr().err
        assert told.count("unknown: found") == 1 and f"unknown: found {found}; allowed: a mapping" in told
        assert "under the header [unknown]" in told and "runs: found 3" in told and "distributions:" not in told
    with pytest.raises(sw.SceneError, match=r"unknown: found {}"):
        sw.infer(SCENE, {}, [])
    assert not solved


def test_unknown_fields_are_told_beside_a_scene_without_wear():
    with pytest.raises(SceneError, match=r"did you mean pinion_torque_Nm\?(.|\n)*wear: missing"):
        sw.infer(SCENE.replace({"wear": None}), {"operation.pinion_torqe_Nm": sw.Normal(1.0, 1.0)}, [])


ALONE = f"""
scene = "scene.toml"
TOP
[unknown]
{K} = {{distribution = "lognormal"}}
[[reading]]
quantity = "transmission_error_amplitude"
value = 8.8
error = 0.05
"""
POINTS = """
[[wear_at_points]]
face_mm = [500, 510]
height_mm = [0, 0]
depth_um = [1, 2]
error_um = 0.1
"""
FROM_FILE = """
[[wear_at_points]]
file = "points.csv"
"""
HEAD = "face_mm,height_mm,depth_um,error_um\n"


@pytest.fixture
def told_of(folder, capsys):
    """What is said of a study file that is refused."""

    def told(study: str, csv: bytes = b"", scene: sw.Scene = SCENE) -> str:
        (folder / "scene.toml").write_text(scene.to_toml())
        (folder / "points.csv").write_bytes(csv)
        (folder / "study.toml").write_text(study)
        assert main(["infer", "study.toml", "-o", "draws.nc", "--workers", "0"]) == 2
        return capsys.readouterr().err

    return told


@pytest.mark.parametrize(
    ("entry", "word"),
    [
        (POINTS.replace("[500, 510]", '[500, "a"]'), "wear_at_points[0].face_mm: found [500, 'a']"),
        (POINTS.replace("[500, 510]", "[]"), "wear_at_points[0].face_mm: found 'no number'"),
        (POINTS.replace("[1, 2]", "[1, true]"), "wear_at_points[0].depth_um: found [1, True]"),
        (POINTS.replace("[1, 2]", f"[1, 1{400 * '0'}]"), "wear_at_points[0].depth_um"),
        (POINTS.replace("[1, 2]", "{a = 1}"), "give one number, not a table"),
        (POINTS + "file = 5", "wear_at_points[0].file: found 5"),
        ("[[worn_flank]]\nmeasured = 5", "worn_flank[0].measured: found 5; allowed: a path in quotes"),
        ("[[worn_flank]]\nmeasured = ['a.nc']", "worn_flank[0].measured: found ['a.nc']"),
        ("[[worn_flank]]\nmeasured = 'a.nc'\nbefore = true", "worn_flank[0].before: found True"),
        ("[[reading]]\nquantity = 'transmission_error_mean'\nvalue = 'a'\nerror = 1", "reading[1].value: found 'a'"),
        (
            "[[reading]]\nquantity = 'transmission_error_mean'\nvalue = true\nerror = 1",
            "reading[1].value: found True",
        ),
        ("[[reading]]\nquantity = 'transmission_error_mean'\nvalue = [1, 2]\nerror = 1", "allowed: one number"),
    ],
)
def test_measurements_that_are_none_are_named_by_their_entry(solved, told_of, entry, word):
    assert word in told_of(ALONE.replace("TOP", "") + entry)
    assert not solved


@pytest.mark.parametrize(
    ("csv", "word"),
    [
        (b"", "no line of numbers"),
        (HEAD.encode(), "no line of numbers"),
        (HEAD.encode() + b"500,0,1,0.1\n510,0,a,0.1\n", "row 2 has 'a' for depth_um"),
        (HEAD.encode() + b"500,0,,0.1\n", "row 1 has '' for depth_um"),
        (HEAD.encode() + b"500,0,1\n", "row 1 has 3 cells"),
        (b"face_mm,face_mm\n1,2\n", "two columns of one name"),
        (b"\xff\xfe\x00", "can't decode"),
    ],
)
def test_tables_that_cannot_be_read_are_told(solved, told_of, csv, word):
    told = told_of(ALONE.replace("TOP", "") + FROM_FILE, csv)
    assert "wear_at_points[0].file" in told and word in told
    assert not solved


def test_a_column_of_another_name_is_told_by_its_name(solved, told_of):
    told = told_of(ALONE.replace("TOP", "") + FROM_FILE, HEAD.replace("height", "hight").encode() + b"500,0,1,0.1\n")
    assert "wear_at_points[0].file: found \"column 'hight_mm'\"" in told and "did you mean height_mm?" in told
    assert "array" not in told


def test_a_quantity_that_the_scene_has_not_is_no_reading(solved, told_of):
    told = told_of(ALONE.replace("TOP", "").replace("transmission_error_amplitude", "mesh_efficiency"))
    assert "reading[0].quantity: found 'mesh_efficiency'" in told and "give the scene [effects.friction]" in told


def test_a_table_of_a_spreadsheet_is_read_and_no_list_beside_it(solved, told_of):
    """With a byte order mark; a column and a list of one name would leave one of them out."""
    csv = b"\xef\xbb\xbf" + HEAD.encode() + b"500,0,1,0.1\n"
    told = told_of(ALONE.replace("TOP", "") + FROM_FILE + "face_mm = [510]\nfar = 1", csv)
    assert "wear_at_points[0].face_mm: found [510]" in told and "byte" not in told
    assert "wear_at_points[0].far" in told_of(ALONE.replace("TOP", "") + FROM_FILE + "far = 1", csv)


@pytest.mark.parametrize(
    ("top", "word"),
    [
        ("life_um = [60, 20000]", "life_um: found 20000; allowed: above 0, up to 10000 um"),
        ("life_um = [true]", "life_um: found True"),
        ("life_um = 60\nlife_body = 'pinion'", "life_body: found 'pinion'"),
        ("k_scatter = inf", "k_scatter: found inf"),
        ("k_scatter = 1e200", "allowed: a fraction, 0 to 100"),
        (f"emulator_share = 1{400 * '0'}", "emulator_share: found '1000"),
    ],
)
def test_lives_that_cannot_be_are_told_before_anything_runs(solved, told_of, top, word):
    assert word in told_of(ALONE.replace("TOP", top))
    assert not solved


def test_no_body_is_asked_for_without_a_life(solved, told_of, capsys):
    pinion = SCENE.replace({"wear.worn_bodies": ["pinion"]})
    assert "life_body: found 'gear'" in told_of(ALONE.replace("TOP", "life_um = 60"), scene=pinion)
    told = told_of(ALONE.replace("TOP", "seed = -1"), scene=pinion)
    assert "seed" in told and "life_body" not in told
    told = told_of(ALONE.replace("TOP", "life_um = 60"), scene=SCENE.replace({"wear": None}))
    assert "allowed: a table [wear]" in told and "life_body" not in told


def test_draws_are_written_before_a_life_fails(solved, short, folder, monkeypatch, capsys):
    """A depth within its range that the flank cannot be worn to."""
    (folder / "study.toml").write_text(ALONE.replace("TOP", "life_um = [9000]"))

    def life(task):
        raise ConvergenceError("too deep")

    monkeypatch.setattr(outcome, "_life", life)
    assert main(["infer", "study.toml", "-o", "draws.nc", "--workers", "0"]) != 0
    told = capsys.readouterr().err
    assert "too deep" in told and "the draws are in draws.nc" in told
    with xr.open_dataset("draws.nc") as draws:
        assert draws.sizes["draw"] > 1000


def test_a_stopped_inference_says_which_runs_are_kept(solved, short, folder, monkeypatch, capsys):
    simulate = outcome.simulate

    def stopping(scene):
        if len(solved) == 5:
            raise KeyboardInterrupt
        return simulate(scene)

    monkeypatch.setattr(outcome, "simulate", stopping)
    torque = f'{TORQUE} = {{distribution = "uniform", low = 1500, high = 1700}}'
    study = ALONE.replace("TOP", "").replace("[[reading]]", f"{torque}\n[[reading]]")
    (folder / "study.toml").write_text(study)
    assert main(["infer", "study.toml", "-o", "draws.nc", "--workers", "0", "--store", "runs"]) == 130
    assert "; 5 solved scenes are kept in runs, the same command continues from them" in capsys.readouterr().err
    monkeypatch.setattr(outcome, "simulate", simulate)
    assert main(["infer", "study.toml", "-o", "draws.nc", "--workers", "0", "--store", "runs"]) == 0
    assert len(solved) == 32


# ---------------------------------------------------------------------- real flanks


@pytest.mark.slow
def test_what_wore_a_flank_is_found_again(tmp_path):
    """k, torque and offset of a simulated flank, through points of a displaced tooth; and k alone as `calibrate`."""
    coarse = {"numerics.profile_points": 51, "numerics.wear_steps": 12, "numerics.tooth_compliance": "rigid"}
    scene = SCENE.replace(coarse | {"wear.until.meshes": 5e8})
    truth = {K: 1.3e-13, TORQUE: 1450.0, OFFSET: 0.03}
    tree = sw.simulate(scene.replace(truth | {"numerics.wear_steps": 32}))
    flank = nominal_flank(scene)
    face, profile, *_ = grid_on(flank, 25, 15)
    flank_set = tree["flank"].to_dataset()
    wear = 1e-3 * flank_set["wear_depth"].isel(wear_step=-1).sel(body="gear").transpose("face", "profile").values
    nodes = grid_of(scene, flank_set["face"].values, 51, "gear")
    depth = FlankReading.of(nodes, face.ravel(), profile.ravel()).read(wear).reshape(face.shape)
    error = 3e-4 * np.random.default_rng(0).standard_normal(face.shape)
    points = displaced(flank, face, profile, error - depth, Displacement.about_axis(0.3, 0.01))
    write_point_grid(tmp_path / "worn.nc", PointGrid(points))
    priors = {K: COEFFICIENT, TORQUE: sw.Normal(1600, 200), OFFSET: sw.Normal(0, 0.05)}
    found = sw.infer(scene, priors, sw.WornFlank(tmp_path / "worn.nc"), emulator_share=2.0, crew=0)
    for key, true in truth.items():
        low, high = found.interval(key, 0.999)
        assert low < true < high, key
    assert found.emulator_shares.max() <= 2.0 and found.shares_of_prior.max() < 0.5
    assert found.fitted()[0][1] == pytest.approx(0.3, rel=0.2)
    placed = scene.replace({TORQUE: 1450.0, OFFSET: 0.03})
    alone = sw.infer(placed, {K: COEFFICIENT}, sw.WornFlank(points), crew=0)
    quick = sw.calibrate(placed, points)
    assert alone.quantile(K, 0.5) == pytest.approx(quick.coefficient, rel=0.02)
    assert alone.runs == 1


@pytest.fixture(scope="module")
def greatest_run():
    """Scene and run up to the end of a prior of the wear coefficient."""
    scene = plan_inference(SCENE, {K: COEFFICIENT}, amplitude(8.0, 0.1, meshes=2e8)).run_scene
    return scene, sw.simulate(scene)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.1, 0.25, 0.5])
def test_runs_to_the_greatest_coefficient_tell_lesser_ones(greatest_run, share):
    """Steps up to the prior's end leave less than 0.8 % of k at lesser ones: 16 plain steps leave up to 4 %."""
    scene, run = greatest_run
    meshes = share * scene.wear.until.meshes
    fine = sw.simulate(scene.replace({"wear.until.meshes": 1.01 * meshes, "numerics.wear_steps": 48}))

    def depth(tree, at):
        flank = tree["flank"].to_dataset().sel(body="gear")
        return CubicSpline(flank["meshes"], flank["wear_depth"].values, axis=0)(at).ravel()

    slope = (depth(fine, 1.01 * meshes) - depth(fine, 0.99 * meshes)) / 0.02
    missed = depth(run, meshes) - depth(fine, meshes)
    assert abs(missed @ slope / (slope @ slope)) < 8e-3
