"""Scatter: distributions, samples, estimates against what is known; solving is made up where a scene is solved."""

from importlib import import_module
from math import comb, exp, log, sqrt

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

import semiwear as sw
from semiwear.cli import main
from semiwear.errors import ConvergenceError, EndlessWearError, SceneError, SemiwearError
from semiwear.scatter.design import design
from semiwear.scatter.estimates import indices, probability, quantile
from semiwear.sweep.files import open_sweep
from semiwear.sweep.outcome import Status
from tests.scenes import SHIPPED, TINY
from tests.strategies.results import synthetic_tree

outcome, command = import_module("semiwear.sweep.outcome"), import_module("semiwear.scatter.command")
SCENE = SHIPPED.replace({**TINY, "wear.until.control_depths_um": [2, 4]})
TORQUE, OFFSET, K = "operation.pinion_torque_Nm", "effects.misalignment.offset_mm", "wear.coefficient_mm2_per_N"


@pytest.fixture
def solved(monkeypatch):
    """Scenes that were solved: by formulas of their torque and offset."""
    scenes = []
    whole = synthetic_tree(3, profiles=4, faces=3, mesh_positions=3)
    made_up = {name: whole[name].to_dataset() for name in ("history", "life")}

    def simulate(scene):
        scenes.append(scene)
        torque, misaligned = scene.operation.pinion_torque_Nm, scene.effects.misalignment
        history = made_up["history"].copy()
        history["root_stress_max"] = history["root_stress_max"] * torque
        history["load_share_max"] = history["load_share_max"] + (misaligned.offset_mm if misaligned else 0.0)
        meshes = history["meshes"] * (1e-13 / scene.wear.coefficient("gear"))
        return xr.DataTree.from_dict(made_up | {"history": history.assign_coords(meshes=meshes)})

    monkeypatch.setattr(outcome, "simulate", simulate)
    monkeypatch.setattr(outcome, "simulate_as_given", lambda scene, **_: outcome.simulate(scene))
    return scenes


# ---------------------------------------------------------------------- distributions


def reference(one):
    """The distribution as scipy has it."""
    if isinstance(one, sw.Normal):
        ends = [(end - one.mean) / one.deviation for end in (one.low, one.high)]
        return stats.truncnorm(*ends, one.mean, one.deviation)
    if isinstance(one, sw.LogNormal):
        return stats.lognorm(sqrt(log(1 + one.variation**2)), scale=one.median)
    if isinstance(one, sw.Uniform):
        return stats.uniform(one.low, one.high - one.low)
    width = one.high - one.low
    return stats.triang((one.mode - one.low) / width, one.low, width)


@pytest.mark.parametrize(
    "one",
    [
        sw.Normal(1600, 80), sw.Normal(0, 1, low=-1), sw.Normal(0, 1, low=3, high=9), sw.LogNormal(1e-13, 0.5),
        sw.Uniform(-1, 3), sw.Triangular(0, 1, 4), sw.Triangular(0, 0, 4), sw.Triangular(0, 4, 4),
    ],
)  # fmt: skip
def test_quantiles_are_those_of_scipy(one):
    shares = np.array([1e-6, 0.01, 0.3, 0.5, 0.9, 0.999])
    np.testing.assert_allclose(one.quantile(shares), reference(one).ppf(shares), rtol=1e-9, atol=1e-12)


def test_a_lognormal_can_be_cut_off():
    one = sw.LogNormal(1.0, 0.5, low=0.5, high=2.0)
    found = one.quantile(np.array([1e-12, 0.5, 1.0 - 1e-12]))
    np.testing.assert_allclose(found, [0.5, 1.0, 2.0], rtol=1e-9)


def test_the_usual_scatter_is_about_the_coefficient_of_the_scene():
    assert sw.usual_wear_coefficient(SCENE) == sw.LogNormal(1e-13, 0.5)
    with pytest.raises(SceneError, match="one number for both"):
        sw.usual_wear_coefficient(SCENE.replace({K: {"gear": 1e-13}}))


# ---------------------------------------------------------------------- samples


def test_ranks_are_correlated_as_asked():
    shape = [sw.LogNormal(1.0, 1.0), sw.Uniform(0, 1), sw.Normal(0, 1)]
    matrix = import_module("semiwear.scatter.design").correlation_matrix(
        ["a", "b", "c"], {("a", "b"): 0.6, ("c", "a"): -0.3}
    )
    # the rank correlation of two normal numbers correlated by r (Pearson 1907)
    np.testing.assert_allclose(
        6.0 / np.pi * np.arcsin(matrix / 2.0), [[1, 0.6, -0.3], [0.6, 1, 0], [-0.3, 0, 1]], atol=1e-12
    )
    found = design(shape, 4096, 3, matrix=matrix, paired=False).values
    ranks = stats.spearmanr(found).statistic
    np.testing.assert_allclose(ranks[[0, 0, 1], [1, 2, 2]], [0.6, -0.3, 0.0], atol=0.02)
    np.testing.assert_allclose(np.median(found, axis=0), [1.0, 0.5, 0.0], atol=0.02)


@pytest.mark.parametrize("paired", [False, True])
def test_more_samples_begin_with_the_fewer(paired):
    shape = [sw.Uniform(0, 1), sw.Normal(0, 1)]
    few, many = (design(shape, count, 5, paired=paired) for count in (16, 32))
    np.testing.assert_array_equal(many.values[:16], few.values[:16])
    if paired:
        np.testing.assert_array_equal(many.values[32:48], few.values[16:32])
        mixed = few.values[32:48]  # of the first field
        np.testing.assert_array_equal(mixed[:, 0], few.values[16:32, 0])
        np.testing.assert_array_equal(mixed[:, 1], few.values[:16, 1])


# ---------------------------------------------------------------------- estimates


def test_order_statistics_cover_a_quantile_as_often_as_they_say():
    rng = np.random.default_rng(0)
    true = stats.lognorm(0.5).ppf(0.1)
    found = [quantile(lives, 0.1, 0.9) for lives in rng.lognormal(0.0, 0.5, (1000, 200))]
    covered = np.mean([one.low <= true <= one.high for one in found])
    assert covered + 2 * sqrt(0.9 * 0.1 / 1000) >= 0.9 and covered < 0.96


@pytest.mark.parametrize("n, ends", [(5, (-np.inf, np.inf)), (6, (1, 6)), (8, (1, 8)), (10, (2, 9)), (20, (6, 15))])
def test_the_median_lies_between_the_order_statistics_of_tables(n, ends):
    """95 %: those of the sign test, e.g. Conover 1999, Practical Nonparametric Statistics, 3.2."""
    found = quantile(np.random.default_rng(n).permutation(np.arange(1.0, n + 1)), 0.5, 0.95)
    assert (found.low, found.high) == ends and found.value == pytest.approx(0.5 * (n + 1))


@pytest.mark.parametrize("share", [0.05, 0.3, 0.9])
def test_order_statistics_are_the_nearest_that_miss_a_quantile_seldom_enough(share):
    """The k-th least of n lies above it where fewer than k samples lie below: a sum of binomial terms."""
    n, miss = 60, 0.05

    def fewer(k):
        return sum(comb(n, i) * share**i * (1.0 - share) ** (n - i) for i in range(k))

    found = quantile(np.arange(1.0, n + 1), share, 1.0 - 2.0 * miss)
    low = max((k for k in range(1, n + 1) if fewer(k) <= miss), default=-np.inf)
    high = min((k for k in range(1, n + 1) if 1.0 - fewer(k) <= miss), default=np.inf)
    assert (found.low, found.high) == (low, high)
    assert found.value == pytest.approx((n + 1 / 3) * share + 1 / 3)  # unbiased in its median: Reiss 1989


def test_few_samples_do_not_tell_a_tail():
    found = quantile(np.arange(5.0), 0.1, 0.95)
    assert found.low == -np.inf and found.high < np.inf
    assert quantile(np.array([3.0]), 0.5, 0.95).value == 3.0


@given(st.integers(1, 60), st.data())
def test_a_probability_lies_in_its_interval(n, data):
    count = data.draw(st.integers(0, n))
    found = probability(np.arange(n) < count, 0.95)
    assert 0.0 <= found.low <= found.value == count / n <= found.high <= 1.0
    test = stats.binomtest(count, n).proportion_ci(0.95, method="exact")
    assert found.low == pytest.approx(test.low) and found.high == pytest.approx(test.high)


def ishigami(x, a=7.0, b=0.1):
    return np.sin(x[:, 0]) + a * np.sin(x[:, 1]) ** 2 + b * x[:, 2] ** 4 * np.sin(x[:, 0])


def test_indices_of_a_function_with_known_ones():
    """Ishigami and Homma 1990; the closed forms in Saltelli et al. 2008, Global Sensitivity Analysis, 4.6."""
    a, b, pi = 7.0, 0.1, np.pi
    parts = np.array([0.5 * (1 + b * pi**4 / 5) ** 2, a**2 / 8, 0.0])
    both = b**2 * pi**8 * (1 / 18 - 1 / 50)
    whole = parts.sum() + both
    first, total = parts / whole, (parts + np.array([both, 0.0, both])) / whole
    drawn = design([sw.Uniform(-pi, pi)] * 3, 4096, 1, paired=True)
    values = ishigami(drawn.values).reshape(5, -1)
    found = indices(values[0], values[1], values[2:], 0.95)
    np.testing.assert_allclose(found.first_order, first, atol=2.0 / sqrt(4096))
    np.testing.assert_allclose(found.total, total, atol=2.0 / sqrt(4096))
    for interval, true in ((found.first_order_interval, first), (found.total_interval, total)):
        assert np.all((interval[:, 0] <= true) & (true <= interval[:, 1]))
    for row in (0, 1, 3):
        spoiled = values.copy()
        spoiled[row, ::7] = np.nan
        np.testing.assert_allclose(indices(spoiled[0], spoiled[1], spoiled[2:], 0.95).total, total, atol=0.05)
    moved = indices(*(1e6 + 2.0 * one for one in (values[0], values[1], values[2:])), 0.95)
    np.testing.assert_allclose(moved.first_order, found.first_order, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(moved.total_interval, found.total_interval, rtol=1e-6, atol=1e-9)


def test_intervals_of_indices_are_as_wide_as_samples_leave_open():
    """One field of two values: its total index is a share of samples, 2 (1/2 +- 1/2 z/sqrt(n))."""
    n = 1024
    a, b = np.random.default_rng(2).choice([-1.0, 1.0], (2, n))
    for confidence in (0.95, 0.6):
        found = indices(a, b, b[None, :], confidence)
        half = stats.norm.ppf(0.5 + 0.5 * confidence) / sqrt(n)
        assert np.ptp(found.total_interval) == pytest.approx(2.0 * half, rel=0.15)
        assert found.total_interval.mean() == pytest.approx(found.total[0], abs=0.5 * half)


def test_what_does_not_vary_has_no_indices_nor_have_three_samples():
    few = np.arange(4.0)
    assert np.isfinite(indices(few, few[::-1], few[None, ::-1], 0.95).total).all()
    assert np.isnan(indices(few[:3], few[2::-1], few[None, 2::-1], 0.95).total).all()
    found = indices(np.ones(8), np.ones(8), np.ones((2, 8)), 0.95)
    assert np.isnan(found.total).all() and np.isnan(found.first_order_interval).all()


# ---------------------------------------------------------------------- a scene


@pytest.mark.parametrize(
    "seeds", [range(4), pytest.param(range(4, 20), marks=pytest.mark.slow)], ids=["4", "16 more"]
)
def test_b10_of_a_lognormal_coefficient_alone_is_known(solved, seeds):
    """Life is inverse to k: L_q = L(k_median) / k_(1-q). One solution tells all samples of all seeds."""
    for seed in seeds:
        found = sw.scatter(SCENE, {K: sw.LogNormal(2e-13, 0.4)}, samples=64, seed=seed, crew=0)
        median = 6e8 * 2 * (1 + 0.035 * 2) / 2.0
        known = median * exp(stats.norm.ppf(0.1) * sqrt(log(1 + 0.4**2)))
        b10 = found.quantile("meshes", 0.1)
        assert b10.low <= known <= b10.high and b10.high / b10.low < 1.6
        assert found.quantile("meshes", 0.5).value == pytest.approx(median, rel=0.03)
        reached = found.probability("meshes", below=known)
        assert reached.low <= 0.1 <= reached.high
    assert len(solved) == len(seeds)  # one a call


def test_indices_tell_what_matters(solved):
    fields = {TORQUE: sw.Normal(1600, 80), OFFSET: sw.Uniform(-0.1, 0.1), K: sw.usual_wear_coefficient(SCENE)}
    found = sw.scatter(SCENE, fields, samples=32, sensitivity=True, crew=0)
    assert len(solved) == 32 * 4 and found.samples.sizes["sample"] == 32 * 5  # those of k are shared
    shares = found.indices()["total"]
    assert float(shares.sel(quantity="root_stress_max gear", field=TORQUE)) == pytest.approx(1.0, abs=0.25)
    assert float(shares.sel(quantity="root_stress_max gear", field=OFFSET)) == 0.0
    assert float(shares.sel(quantity="load_share_max", field=OFFSET)) == pytest.approx(1.0, abs=0.25)
    assert np.isnan(shares.sel(quantity="wear_depth_max gear")).all()
    settled = found.convergence()
    assert list(settled["samples_drawn"].values) == [8, 16, 32] and np.isfinite(settled["value"]).all()
    told = str(found)
    assert "64 samples" in told and "B10" in told and "95 % intervals" in told
    with pytest.raises(SemiwearError, match='did you mean "load_share_max"'):
        found.quantile("load_share", 0.1)
    with pytest.raises(SceneError, match="share"):
        found.quantile("meshes", 1.0)


@pytest.mark.parametrize(
    "fields, options, parts",
    [
        ({}, {}, ["a mapping"]),
        ({TORQUE: 3}, {}, ["Normal, LogNormal"]),
        ({TORQUE: sw.Normal(1600, -1), OFFSET: sw.Uniform(1, 0)}, {}, ["deviation", "exchange them?"]),
        ({TORQUE: sw.Normal(300, 15, low=1e6)}, {}, ["low and high", "1e+06 to inf", "nothing is left"]),
        ({TORQUE: sw.LogNormal(300, 0.1, low=-2, high=-1)}, {}, ["high", "greater than low = 0"]),
        ({TORQUE: sw.Normal(300, 15)}, {"samples": 8, "measure": "life"}, ["measure", "effects.run_life"]),
        ({TORQUE: sw.Normal(10, 20)}, {}, ["samples as far out as", "cut the distribution off"]),
        ({"operation.torque": sw.Normal(10, 2)}, {"samples": 100}, ["did you mean pinion_torque_Nm", "give 128"]),
        ({TORQUE: sw.Triangular(0, 9, 4)}, {"seed": -1}, ["mode", "seed"]),
        ({TORQUE: sw.Normal(9, "1")}, {"confidence": 95}, ["deviation", "0.95 is usual"]),
        ({TORQUE: sw.Normal(9, 1)}, {"correlation": {(TORQUE, "offset"): 2}}, ["give it a distribution", "above -1"]),
        ({"gear_pair.gear_teeth": sw.Uniform(150, 170)}, {}, ["a whole number does not scatter"]),
        (
            {TORQUE: sw.Normal(1600, 1), OFFSET: sw.Uniform(0, 1)},
            {"correlation": {(TORQUE, OFFSET): 0.5}, "sensitivity": True},
            ["independent fields"],
        ),
        (
            {TORQUE: sw.Normal(1600, 1), OFFSET: sw.Uniform(0, 1), K: sw.LogNormal(1e-13, 0.5)},
            {"correlation": {(TORQUE, OFFSET): 0.9, (TORQUE, K): 0.9, (OFFSET, K): -0.9}},
            ["correlations that are compatible"],
        ),
    ],
)
def test_what_is_wrong_is_told_before_anything_runs(solved, fields, options, parts):
    with pytest.raises(SceneError) as error:
        sw.scatter(SCENE, fields, crew=0, **options)
    for part in parts:
        assert part in str(error.value)
    assert not solved


def test_distributions_that_are_none_are_told_with_the_number_of_samples(solved):
    with pytest.raises(SceneError, match=r"samples: found 3(.|\n)*distributions: found"):
        sw.scatter(SCENE, [TORQUE], samples=3, crew=0)


@pytest.mark.parametrize("table, found", [("scatter = 3\n", "3"), ("[scatter]\n", "{}")])
def test_fields_that_do_not_scatter_are_told_by_their_table(solved, sweep_study, capsys, table, found):
    assert sweep_study(f'samples = 3\nscene = "spur_fzg_c"\n{table}') == 2
    told = capsys.readouterr().err
    assert "2 problems" in told and f"scatter: found {found}; allowed: a mapping" in told
    assert "under the header [scatter]" in told and not solved


def test_few_solved_samples_tell_all_where_an_emulator_is_good_enough(solved):
    fields = {TORQUE: sw.Normal(1600, 80), OFFSET: sw.Uniform(-0.1, 0.1)}
    measure = ["root_stress_max", "load_share_max"]
    every = sw.scatter(SCENE, fields, samples=128, measure=measure, crew=0)
    solved.clear()
    found = sw.scatter(SCENE, fields, samples=128, emulate=0.05, measure=measure, crew=0)
    assert len(solved) == int((found.samples["emulated"] == 0).sum()) == 32
    for name in ("root_stress_max gear", "load_share_max"):
        true, told = every.quantities[name], found.quantities[name]
        assert np.mean(np.abs(told - true) <= found.errors[name] + 1e-9 * np.abs(true).max()) >= 0.95
        assert found.errors[name] <= 0.05 * true.std() * 1.2
        one = found.quantile(name, 0.5)
        assert one.low <= every.quantile(name, 0.5).value <= one.high
    assert "32 scenes were solved and 96 emulated" in str(found) and "emulated within" in str(found)
    half = sw.scatter(SCENE, fields, samples=64, sensitivity=True, emulate=0.05, measure="load_share_max", crew=0)
    assert float(half.indices()["total"].sel(quantity="load_share_max", field=OFFSET)) == pytest.approx(1.0, abs=0.2)


@pytest.fixture
def noisy(solved, monkeypatch):
    """Load shares that no emulator can follow."""
    rough = np.random.default_rng(0)
    simulate = outcome.simulate

    def rough_run(scene):
        tree = simulate(scene)
        history = tree["history"].to_dataset()
        tree["history"] = xr.DataTree(history.assign(load_share_max=history["load_share_max"] * rough.uniform()))
        return tree

    monkeypatch.setattr(outcome, "simulate", rough_run)


@pytest.mark.slow  # of a study, below, it is tried quickly
def test_an_emulator_that_is_not_good_enough_is_refused(solved, noisy):
    own = {"samples": 64, "sensitivity": True, "measure": "load_share_max"}
    with pytest.raises(SemiwearError, match=r"after 64 solved samples errors are above 0.1 .*load_share_max"):
        sw.scatter(SCENE, {TORQUE: sw.Normal(1600, 80)}, **own, emulate=0.1, crew=0)
    with pytest.raises(SceneError, match="emulate"):
        sw.scatter(SCENE, {TORQUE: sw.Normal(1600, 80)}, samples=64, emulate=-1, crew=0)


STUDY = f"""
scene = "face_gear_25x160"
samples = 16
sensitivity = true
before_meshes = [1e7, 1e20]
[set]
wear.until.control_depths_um = [2, 4]
[scatter]
{TORQUE} = {{distribution = "normal", mean = 1600, deviation = 80}}
{K} = {{distribution = "lognormal"}}
"""


@pytest.fixture
def sweep_study(tmp_path, monkeypatch):
    """Runs `semiwear sweep` on the text of a study, in a folder of its own; returns the exit code."""
    monkeypatch.chdir(tmp_path)

    def run(text: str, *options: str) -> int:
        (tmp_path / "study.toml").write_text(text)
        return main(["sweep", "study.toml", "-o", "study.nc", "--workers", "0", *options])

    return run


def test_a_study_file_may_give_distributions(solved, unseen, sweep_study, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(import_module("semiwear.sweep.page"), "QUANTITIES", ("meshes",))
    monkeypatch.setattr(command, "_MOST_PICTURES", 1)
    assert sweep_study(STUDY, "--report", "study.html") == 0
    told = capsys.readouterr().out
    assert "32 samples of" in told and "B10" in told and "the life ends before 1e+07 meshes: 0 %" in told
    found = open_sweep("study.nc")
    assert found["quantile_value"].dims == ("quantity", "share") and "total" in found
    assert list(found["probability"].values) == [0.0, 1.0] and 0.0 < float(found["probability_high"][0]) < 0.2
    page = (tmp_path / "study.html").read_text()
    assert "from ever more samples" in page
    assert "Quantiles of 32 samples" in page and "What meshes_to_limit depends on" in page


def test_a_field_that_no_scene_has_is_told_once(spur):
    with pytest.raises(sw.SceneError) as caught:
        sw.scatter(spur, distributions={"x": 1, "operation.pinion_torqe_Nm": 2.0})
    assert [problem.field for problem in caught.value.problems] == ["x", "operation.pinion_torqe_Nm"]


def test_a_study_file_tells_all_its_problems(solved, sweep_study, capsys):
    bad = (
        STUDY.replace('"normal"', '"norml"').replace("= 16", "= 17").replace('"lognormal"', '"lognormal", spread = 1')
    )
    assert sweep_study('measure = "x"\n' + bad + "[vary]\noperation.pinion_speed_rpm = [1]\n") == 2
    told = capsys.readouterr().err
    for part in ('did you mean "normal"', "give 32", "spread", "make two studies", "measure"):
        assert part in told
    assert not solved


EMULATED = f"""
scene = "face_gear_25x160"
measure = ["root_stress_max", "load_share_max"]
samples = 128
emulate = 0.05
[set]
wear.until.control_depths_um = [2, 4]
[scatter]
{TORQUE} = {{distribution = "normal", mean = 1600, deviation = 80}}
{OFFSET} = {{distribution = "uniform", low = -0.1, high = 0.1}}
"""


@pytest.mark.slow
def test_a_study_file_may_ask_for_few_solved_samples(solved, unseen, sweep_study, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(import_module("semiwear.sweep.page"), "QUANTITIES", ("load_share_max",))
    monkeypatch.setattr(command, "_MOST_PICTURES", 1)
    assert sweep_study(EMULATED, "--report", "study.html") == 0
    told = capsys.readouterr().out
    assert len(solved) == 32 and "128 scenes: 128 done; of these 32 were solved and 96 emulated" in told
    assert "emulated within" in told
    found = open_sweep("study.nc")
    assert int(found["emulated"].sum()) == 96
    same = sw.scatter(
        sw.load_scene("face_gear_25x160").replace({"wear.until.control_depths_um": [2, 4]}),
        {TORQUE: sw.Normal(1600, 80), OFFSET: sw.Uniform(-0.1, 0.1)},
        samples=128, emulate=0.05, measure=["root_stress_max", "load_share_max"], crew=0,
    )  # fmt: skip
    np.testing.assert_array_equal(found["load_share_max"], same.samples["load_share_max"])
    stated = found["stated_error"].sel(quantity="load_share_max")
    assert float(stated) == same.errors["load_share_max"] > 0.0
    page = (tmp_path / "study.html").read_text()
    assert "32 scenes were solved and 96 emulated" in page and "stated error of the emulator" in page
    # more samples: only what the emulator needs beyond the kept ones is solved
    solved.clear()
    assert sweep_study(EMULATED.replace("128", "256"), "--resume") == 0
    assert not solved


@pytest.mark.parametrize(
    ("given", "parts"),
    [
        ("emulate = -1\nsamples = 100", ["emulate: found -1", "greater than 0", "give 128"]),
        ("emulate = true\nsamples = 64", ["emulate: found True", "greater than 0"]),
        ("emulate = nan\nconfidence = 1.0\nsamples = 64", ["emulate: found nan", "confidence: found 1.0"]),
        ("emulate = 0.1\nsamples = 16", ["samples: found 16", "32 or more beside emulate"]),
        ('emulate = "0.1"\nsamples = 64\nsensitivity = 1', ["emulate: found '0.1'", "sensitivity: found 1"]),
        ("emulat = 0.1\nsamples = 64", ["did you mean emulate?"]),
    ],
)
def test_what_is_wrong_with_emulation_is_told_before_anything_runs(solved, sweep_study, capsys, given, parts):
    bad = EMULATED.replace("samples = 128\nemulate = 0.05", given)
    assert sweep_study(bad) == 2
    told = capsys.readouterr().err
    for part in parts:
        assert part in told, told
    assert not solved


def test_emulation_without_scatter_or_its_extra_is_refused(solved, sweep_study, monkeypatch, capsys):
    varied = f'scene = "face_gear_25x160"\nemulate = 0.1\n[vary]\n{TORQUE} = [800, 1600]\n'
    assert sweep_study(varied) == 2
    assert "beside a table [scatter]" in capsys.readouterr().err
    monkeypatch.setattr(import_module("semiwear.emulator"), "find_spec", lambda name: None)
    assert sweep_study(EMULATED) != 0
    assert "semiwear[infer]" in capsys.readouterr().err
    assert not solved


def test_a_study_whose_emulator_is_too_rough_says_so(solved, noisy, sweep_study, tmp_path, capsys):
    alone = EMULATED.replace("128", "64\nsensitivity = true").replace('"root_stress_max", ', "")
    assert sweep_study(alone) != 0
    assert "after 64 solved samples errors are above 0.05 of a standard deviation" in capsys.readouterr().err
    assert len(list((tmp_path / "study.nc.scenes").glob("*.npz"))) == 64 and not (tmp_path / "study.nc").exists()


# ---------------------------------------------------------------------- lives without end


def test_the_order_statistic_of_lives_some_of_which_have_no_end():
    lives = np.array([4.0, np.inf, 1.0, 3.0, np.inf, 2.0, np.inf, np.inf])
    assert quantile(lives, 0.25, 0.5).value == 2.0
    assert quantile(lives, 0.5, 0.5).value == 4.0
    above = quantile(lives, 0.6, 0.5)
    assert above.value == np.inf and above.high == np.inf and above.low == 4.0


@pytest.fixture
def endless(monkeypatch, solved):
    """Scenes below some torque whose control point wears no further."""
    known = outcome.simulate

    def simulate(scene):
        if scene.operation.pinion_torque_Nm < 1600.0:
            raise EndlessWearError("wears no further")
        return known(scene)

    monkeypatch.setattr(outcome, "simulate", simulate)


def test_samples_that_never_get_there_outlive_all_others(endless):
    found = sw.scatter(SCENE, {TORQUE: sw.Normal(1600, 80)}, samples=64, measure="load_share_max", crew=0)
    assert (found.samples["status"].values == Status.ENDLESS).sum() == 32
    assert len(found.values("meshes")) == 64 and len(found.values("load_share_max")) == 32
    before = found.probability("meshes", below=1e20)
    assert before.value == 0.5 and before.low < 0.5 < before.high
    assert float(found.reached_before([1e20])["probability"][0]) == 0.5
    assert found.quantile("meshes", 0.6).value == np.inf
    assert "32 wear no further" in str(found) and "without end" in str(found) and "failed" not in str(found)
    assert np.isinf(found.quantiles().value.sel(quantity="meshes", share=0.9))


def test_lives_without_end_are_not_emulated(endless):
    with pytest.raises(SemiwearError, match="wear no further"):
        sw.scatter(SCENE, {TORQUE: sw.Normal(1600, 80)}, samples=64, emulate=0.5, measure="history", crew=0)


def test_lives_that_no_wear_ends_are_not_emulated(monkeypatch, solved):
    """Another failure ends them: their scenes are solved, and infinite until the depth of wear."""
    known = outcome.simulate

    def simulate(scene):
        tree = known(scene)
        life = tree["life"].to_dataset()
        never = np.asarray(np.inf if scene.operation.pinion_torque_Nm < 1600.0 else 1e9)
        tree["life"] = xr.DataTree(life.assign(meshes_to_limit=((), never)))
        return tree

    monkeypatch.setattr(outcome, "simulate", simulate)
    measure = ["meshes_to_limit", "load_share_max"]
    found = sw.scatter(SCENE, {TORQUE: sw.Normal(1600, 80)}, samples=16, measure=measure, crew=0)
    assert np.isinf(found.values("meshes_to_limit")).sum() == 8 and not found.samples["status"].any()
    with pytest.raises(SemiwearError, match="wear no further"):
        sw.scatter(SCENE, {TORQUE: sw.Normal(1600, 80)}, samples=64, emulate=0.5, measure=measure, crew=0)


def test_the_first_failure_ends_a_life_before_its_depth(solved):
    found = sw.scatter(SCENE, {TORQUE: sw.Normal(1600, 80)}, samples=4, measure=["history", "life"], crew=0)
    ends = found.values("meshes_to_end")
    assert not (ends == found.values("meshes_to_limit")).any()
    reached = found.reached_before([ends.max() * 1.001, ends.min() * 0.999])
    assert reached["probability"].values.tolist() == [1.0, 0.0] and reached.attrs["ends"] == "the life ends"


def test_samples_that_are_all_solved_need_no_emulator(solved, noisy):
    found = sw.scatter(
        SCENE, {TORQUE: sw.Normal(1600, 80)}, samples=64, emulate=0.1, measure="load_share_max", crew=0
    )
    assert len(solved) == 64 and not found.samples["emulated"].any() and not found.errors
    assert np.ptp(found.values("load_share_max")) > 0.0


def test_samples_that_are_all_solved_have_the_intervals_of_solved_ones(solved):
    fields = {TORQUE: sw.Normal(1600, 80), OFFSET: sw.Uniform(-0.05, 0.05)}
    whole = sw.scatter(SCENE, fields, samples=32, measure="load_share_max", crew=0)
    found = sw.scatter(SCENE, fields, samples=32, emulate=0.5, measure="load_share_max", crew=0)
    assert not found.samples["emulated"].any() and not found.errors
    assert found.quantile("load_share_max", 0.5) == whole.quantile("load_share_max", 0.5)


@pytest.mark.parametrize("sensitivity", ["true", "false"])
def test_a_study_of_which_every_sample_fails_tells_why(solved, sweep_study, monkeypatch, capsys, sensitivity):
    def simulate(scene):
        raise ConvergenceError("load sharing stopped")

    monkeypatch.setattr(outcome, "simulate", simulate)
    study = STUDY.replace("sensitivity = true", f"sensitivity = {sensitivity}")
    assert sweep_study(study, "--report", "study.html") == 0
    assert "load sharing stopped" in capsys.readouterr().out
    found = open_sweep("study.nc")
    assert (found["status"] == Status.FAILED).all() and "load sharing stopped" in str(found["message"].values[0])
    assert found.sizes["quantity"] == 0 and np.isnan(found["probability"]).all()
