"""The search for best designs, on quantities that are known formulas of the varied fields."""

import json
import re
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from semiwear.cli import main
from semiwear.optimise import command
from semiwear.optimise import designs as designs_module
from semiwear.optimise.designs import COARSE, DOUBLED, OWN, at_resolution
from semiwear.optimise.quantity import limits_of, quantity_of
from semiwear.optimise.run import plan_search
from semiwear.optimise.space import space_of
from semiwear.optimise.surrogate import Surrogate
from semiwear.simulate import NoProgress
from semiwear.sweep.measure import Measured
from semiwear.sweep.outcome import Outcome, Status
from semiwear.sweep.scenes import Task
from tests.strategies.results import synthetic_tree

PINION, GEAR = "effects.modification.pinion.tip_relief_um", "effects.modification.gear.tip_relief_um"
RELIEFS = ("tip_relief_um", "tip_relief_length_mm", "root_relief_um", "root_relief_length_mm", "crowning_um",
           "lead_slope_um", "bias_um")  # fmt: skip
Formula = Callable[[float, float], float]


@pytest.fixture
def scene(shipped: sw.Scene) -> sw.Scene:
    return shipped.replace({"wear.until.meshes": 1e6})


def solve_by(monkeypatch: pytest.MonkeyPatch, solve: Callable[[Task], Outcome]) -> None:
    """Let designs be solved by a function, alone or by a crew."""
    for module in (designs_module, import_module("semiwear.sweep.processes")):
        monkeypatch.setattr(module, "solve", solve)


@pytest.fixture
def formulas(monkeypatch: pytest.MonkeyPatch) -> dict[str, Formula]:
    """Quantities by formulas of both reliefs; on the coarse grid all are 3 % too low."""
    known: dict[str, Formula] = {}

    def solve(task: Task) -> Outcome:
        modification = task.scene.effects.modification
        x, y = (
            (0.0 if body is None else body.tip_relief_um for body in (modification.pinion, modification.gear))
            if modification
            else (0.0, 0.0)
        )
        wrong = 0.97 if task.scene.numerics.face_slices < 61 else 1.0
        values = {path: np.array([0.0, wrong * f(x, y)]) for path, f in known.items()}
        if any(np.isnan(value).any() for value in values.values()):
            return Outcome(task.key, Status.FAILED, "no load sharing")
        return Outcome(task.key, Status.DONE, measured=Measured(values))

    solve_by(monkeypatch, solve)
    return known


def bowl(x: float, y: float) -> float:
    return 5.0 + (x / 60.0 - 0.7) ** 2 + 2.0 * (y / 60.0 - 0.4) ** 2 + 0.5 * (x / 60.0 - 0.7) * (y / 60.0 - 0.4)


def test_the_bottom_of_a_bowl_is_found(scene: sw.Scene, formulas: dict[str, Formula]) -> None:
    formulas["/history/wear_depth_max"] = bowl
    best = sw.optimise(scene, {PINION: (0, 60), GEAR: (0, 60)}, minimise="wear_depth_max", most=40, workers=0)
    assert best.changes[PINION] == pytest.approx(42.0, abs=1.5)
    assert best.changes[GEAR] == pytest.approx(24.0, abs=1.5)
    assert best.scene.numerics == scene.numerics
    assert best.kept
    assert best.told[0].best == pytest.approx(5.0, rel=1e-3)
    assert best.told[0].before == pytest.approx(bowl(0.0, 0.0))


def test_limits_hold_on_the_fine_grid_although_the_coarse_one_says_less(
    scene: sw.Scene, formulas: dict[str, Formula]
) -> None:
    formulas["/history/wear_depth_max"] = bowl
    formulas["/history/transmission_error_amplitude"] = lambda x, y: 1.0 + 0.02 * x
    best = sw.optimise(
        scene, {PINION: (0, 60), GEAR: (0, 60)}, minimise="wear_depth_max",
        subject_to={"transmission_error_amplitude": "<= 1.6"}, most=40, workers=0,
    )  # fmt: skip
    assert best.kept
    assert 1.0 + 0.02 * best.changes[PINION] <= 1.6 * 1.002
    # the margin alone would keep the limit after as many designs as are solved on the fine grid at most
    assert (best.designs["resolution"] == 2).sum() <= 4
    # the bowl's bottom along y under x = 30
    assert best.told[0].best <= min(bowl(30.0, y) for y in np.linspace(0.0, 60.0, 601)) * 1.002


def test_limits_that_no_design_keeps_are_told(scene: sw.Scene, formulas: dict[str, Formula]) -> None:
    formulas["/history/wear_depth_max"] = bowl
    best = sw.optimise(
        scene, {PINION: (0, 60)}, minimise="wear_depth_max", subject_to={"wear_depth_max": "<= 1"}, most=12, workers=0
    )
    assert not best.kept
    assert "NO design" in best.verdict
    assert not best.designs["feasible"].any()


def test_the_front_of_two_aims(scene: sw.Scene, formulas: dict[str, Formula]) -> None:
    formulas["/history/wear_depth_max"] = lambda x, y: 1.0 + (x / 60.0) ** 2 + 0.1 * (y / 60.0) ** 2
    formulas["/history/load_share_max"] = lambda x, y: 1.0 + (1.0 - x / 60.0) ** 2 + 0.1 * (y / 60.0) ** 2
    found = sw.optimise(
        scene, {PINION: (0, 60), GEAR: (0, 60)}, minimise=["wear_depth_max", "load_share_max"], most=40, workers=0
    )
    wear, share = found.front["wear_depth_max"].values, found.front["load_share_max"].values
    assert wear.size >= 5
    # on the front sqrt(a - 1) + sqrt(b - 1) = 1 with y = 0
    np.testing.assert_allclose(
        np.sqrt(np.maximum(wear - 1.0, 0.0)) + np.sqrt(np.maximum(share - 1.0, 0.0)), 1.0, atol=0.03
    )
    order = np.argsort(wear)
    assert (np.diff(share[order]) < 0.0).all()
    assert 10.0 < found.changes[PINION] < 50.0


def test_choices_and_designs_that_fail(scene: sw.Scene, formulas: dict[str, Formula]) -> None:
    formulas["/history/wear_depth_max"] = lambda x, y: np.nan if y > 30.0 else bowl(x, y) - 3.0 * (y == 20.0)
    best = sw.optimise(scene, {PINION: (0, 60), GEAR: [0, 10, 20, 40]}, minimise="wear_depth_max", most=40, workers=0)
    assert best.changes[GEAR] == 20
    failed = best.designs["message"] == "no load sharing"
    assert failed.any()
    assert np.isnan(best.designs["wear_depth_max"].values[failed.values]).all()
    assert not best.designs["feasible"].values[failed.values].any()


def test_a_kink_and_a_limit_that_meet_are_found(scene: sw.Scene, formulas: dict[str, Formula]) -> None:
    """The least lies in a corner between a fold of the aim and the border of what is allowed."""
    formulas["/history/wear_depth_max"] = lambda x, y: 2.0 + abs(x / 60.0 - 0.61) + 0.3 * (1.0 - y / 60.0)
    formulas["/history/load_share_max"] = lambda x, y: 0.5 + max(0.0, y / 60.0 - 0.4) * (0.5 + x / 60.0)
    best = sw.optimise(
        scene, {PINION: (0, 60), GEAR: (0, 60)}, minimise="wear_depth_max",
        subject_to={"load_share_max": "<= 0.6"}, most=40, workers=0,
    )  # fmt: skip
    grid = np.linspace(0.0, 60.0, 241)
    least = min(
        formulas["/history/wear_depth_max"](x, y)
        for x in grid
        for y in grid
        if formulas["/history/load_share_max"](x, y) <= 0.6
    )
    assert best.kept
    assert best.told[1].best <= 0.6
    assert best.told[0].best <= 1.005 * least


def test_of_two_valleys_the_deeper_one_is_found(scene: sw.Scene, formulas: dict[str, Formula]) -> None:
    def valleys(x: float, y: float) -> float:
        wide = ((x - 10.0) / 20.0) ** 2 + ((y - 12.0) / 20.0) ** 2
        deep = ((x - 46.0) / 9.0) ** 2 + ((y - 44.0) / 9.0) ** 2
        return 3.0 - np.exp(-wide) - 1.5 * np.exp(-deep)

    formulas["/history/wear_depth_max"] = valleys
    best = sw.optimise(scene, {PINION: (0, 60), GEAR: (0, 60)}, minimise="wear_depth_max", most=40, workers=0)
    assert best.told[0].best < 1.02 * valleys(46.0, 44.0)


def test_a_choice_that_no_scan_saw_is_found(scene: sw.Scene, formulas: dict[str, Formula]) -> None:
    """Forty choices of one field: a scan of a dozen designs holds few of them."""
    formulas["/history/wear_depth_max"] = bowl
    choices = [float(one) for one in np.linspace(1.0, 60.0, 40)]
    best = sw.optimise(scene, {PINION: (0, 60), GEAR: choices}, minimise="wear_depth_max", most=40, workers=0)
    assert best.told[0].best <= 1.0005 * min(bowl(x, y) for x in np.linspace(0.0, 60.0, 241) for y in choices)
    shapes = {"effects.modification.pinion.relief_shape": ["linear", "parabolic"], GEAR: [0, 24, 50]}
    best = sw.optimise(scene, shapes | {PINION: (0, 60)}, minimise="wear_depth_max", most=40, workers=0)
    assert best.changes[GEAR] == 24
    assert best.changes[PINION] == pytest.approx(42.0, abs=1.5)


def test_choices_alone_are_each_solved_once(scene: sw.Scene, formulas: dict[str, Formula]) -> None:
    formulas["/history/wear_depth_max"] = bowl
    vary = {PINION: [0, 20, 40, 60], GEAR: [0, 20, 40]}
    best = sw.optimise(scene, vary, minimise="wear_depth_max", workers=0)
    assert (best.changes[PINION], best.changes[GEAR]) == (40, 20)
    coarse = best.designs.isel(sample=best.designs["resolution"].values == 0)
    pairs = list(zip(*(coarse[name].values for name in coarse.coords if "field" in coarse[name].attrs), strict=True))
    assert len(set(pairs)) == len(pairs) == 12


def test_a_surrogate_goes_through_what_is_known(scene: sw.Scene) -> None:
    space = space_of(scene, {PINION: (0, 60), GEAR: (0, 60)})
    places = np.random.default_rng(3).uniform(size=(20, 2))
    values = np.stack([np.sin(3.0 * places[:, 0]) * places[:, 1], 1.0 + 2.0 * places @ [1.0, -3.0]], axis=1)
    failed = np.array([[0.99, 0.01]])
    found = Surrogate(space, places, values, failed)
    np.testing.assert_allclose(found.at(places), values, atol=1e-9)
    fresh = np.random.default_rng(4).uniform(size=(50, 2))
    np.testing.assert_allclose(found.at(fresh)[:, 1], 1.0 + 2.0 * fresh @ [1.0, -3.0], atol=1e-8)
    assert found.distance(places).max() == 0.0
    assert found.may_fail(failed).all()
    assert not found.may_fail(places).any()
    few = Surrogate(space, places[:2], values[:2], failed)  # too few for a plane
    np.testing.assert_allclose(few.at(places[:2]), values[:2], atol=1e-9)


def test_choices_without_an_order_are_equally_far_apart(scene: sw.Scene) -> None:
    shape, radius = "effects.modification.pinion.relief_shape", "gear_pair.pinion_tip_edge_radius_mm"
    space = space_of(scene, {shape: ["linear", "parabolic"], radius: [0.2, 0.3, 0.4]})
    at = space.snapped(np.array([0.1, 0.1]))
    np.testing.assert_allclose(at, [0.25, 1.0 / 6.0])
    surrogate = Surrogate(space, at[None, :], np.zeros((1, 1)), np.zeros((0, 2)))
    far = surrogate.distance(np.array([[0.75, 1.0 / 6.0], [0.25, 0.5], [0.25, 5.0 / 6.0]]))
    np.testing.assert_allclose(far, [0.5, 1.0 / 3.0, 2.0 / 3.0])


def test_whole_numbers_stand_for_all_between(scene: sw.Scene) -> None:
    field = space_of(scene, {"gear_pair.pinion_teeth": (23, 26)}).fields[0]
    assert field.values == (23, 24, 25, 26)
    assert not field.continuous
    assert [field.value(place) for place in (0.0, 0.3, 0.6, 1.0)] == [23, 24, 25, 26]
    assert space_of(scene, {"gear_pair.pinion_teeth": (23, 26)}).start(scene)[0] == pytest.approx(0.625)


def test_all_that_is_wrong_is_told_at_once(scene: sw.Scene) -> None:
    with pytest.raises(sw.SceneError) as caught:
        sw.optimise(
            scene, {
                "effects.modification.pinion.tip_releif_um": (0, 60), GEAR: (60, 0), PINION: (0, 1, 2),
                "operation.pinion_torque_Nm": (300, 300),
            },
            minimise="wear_depht_max", subject_to={"load_share_max": "< 1", "root_stress_max[tip]": "<= 1"}, most=0,
        )  # fmt: skip
    text = str(caught.value)
    for part in (
        "tip_relief_um",
        "exchange the two",
        "ends that differ",
        "two numbers",
        "wear_depth_max",
        '"<= 2.5"',
        "in the brackets",
        "most",
    ):
        assert part in text, part


def test_quantities_by_body_and_time() -> None:
    problems: list = []
    measured = Measured(
        {"/history/root_stress_max": np.array([[100.0, 90.0], [130.0, 80.0], [120.0, 110.0]])},
        {"body": np.array(["pinion", "gear"])},
    )
    for text, value in (
        ("root_stress_max", 120.0),
        ("root_stress_max[gear]", 110.0),
        ("root_stress_max[unworn]", 100.0),
        ("root_stress_max[worst]", 130.0),
        ("root_stress_max[gear, unworn]", 90.0),
    ):
        quantity = quantity_of("minimise", text, problems)
        assert quantity is not None
        assert quantity.value(measured, low_is_good=True) == value
    assert quantity.value(Measured(), low_is_good=True) != quantity.value(Measured(), low_is_good=True)
    (limit,) = limits_of({"root_stress_max[gear]": ">= 95"}, problems)
    assert not problems
    assert (limit.bound, limit.at_most) == (95.0, False)
    assert limit.quantity.value(measured, low_is_good=False) == 110.0


@pytest.mark.parametrize("text", ["<= 1.2.3", "<= 1e999", "<= .", ">= nan"])
def test_a_limit_is_a_finite_number(text: str) -> None:
    problems: list = []
    assert limits_of({"load_share_max": text}, problems) == ()
    assert "give a sign and a number" in str(problems[0])


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("<= 3,5", '"<= 3.5"'), ("< 3 MPa", '"<= 3"'), ("≥1e8", '">= 1e8"'), ("=> 2", '">= 2"'),
        ("2.5", '"<= 2.5" or ">= 2.5"'), (2.5, '"<= 2.5" or ">= 2.5"'),
    ],
)  # fmt: skip
def test_what_is_no_limit_is_answered_with_the_one_that_was_meant(text: object, meant: str) -> None:
    problems: list = []
    assert limits_of({"root_stress_max": text}, problems) == ()
    (problem,) = problems
    assert problem.fix == f"did you mean {meant}?" and problem.allowed.endswith("in MPa")


@pytest.mark.parametrize(
    ("quantity", "needed"),
    [
        ("meshes_to_limit", "[effects.run_life]"),
        ("hours_to_limit", "[effects.run_life] and operation.pinion_speed_rpm"),
        ("contact_temperature_max", "[effects.flash_temperature]"),
        ("wear_depth_max_pinion", '"pinion" among wear.worn_bodies'),
        ("subsurface_stress_max", '"patch" as numerics.fidelity'),
    ],
)
def test_quantities_that_no_result_of_the_scene_has_are_told_before_anything_runs(
    scene: sw.Scene, formulas: dict[str, Formula], quantity: str, needed: str
) -> None:
    with pytest.raises(sw.SceneError) as caught:
        sw.optimise(scene, {PINION: (0, 60)}, minimise=quantity, subject_to={quantity: "<= 1"}, workers=0)
    assert [one.field for one in caught.value.problems] == ["minimise", f"subject_to.{quantity}"]
    assert all(one.fix == f"its result has no {quantity}: give the scene {needed}" for one in caught.value.problems)


def test_what_a_design_brings_is_not_missed(scene: sw.Scene) -> None:
    plan_search(scene, {"effects.run_life.depth_limit_um": (10, 60)}, maximise="meshes_to_limit")
    plan_search(scene, {"wear.worn_bodies": [["gear"], ["pinion", "gear"]]}, minimise="wear_depth_max_pinion")


def test_one_quantity_is_not_to_be_small_and_great(scene: sw.Scene) -> None:
    with pytest.raises(sw.SceneError, match="another quantity than the first"):
        sw.optimise(scene, {PINION: (0, 60)}, minimise="load_share_max", maximise=" load_share_max")


def test_both_values_of_a_quantity_that_is_looked_at_both_ways_are_told(
    scene: sw.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    def solve(task: Task) -> Outcome:
        changed = task.scene.effects.modification
        relief = 0.0 if changed is None or changed.pinion is None else changed.pinion.tip_relief_um
        stress = {"/history/root_stress_max": np.array([100.0 + relief, 200.0 - relief])}
        return Outcome(task.key, Status.DONE, measured=Measured(stress, {"body": np.array(["pinion", "gear"])}))

    solve_by(monkeypatch, solve)
    limits = {"root_stress_max": [">= 120", "<= 180"]}
    best = sw.optimise(scene, {PINION: (0, 60)}, minimise="root_stress_max", subject_to=limits, most=8, workers=0)
    greatest, least = best.designs["root_stress_max"].values, best.designs["root_stress_max (least)"].values
    np.testing.assert_allclose(greatest + least, 300.0)
    assert (greatest >= least).all() and (greatest > least).any()
    assert best.told[0].best == best.front["root_stress_max"].values[0]


def test_an_accuracy_settles_the_numbers_once(
    scene: sw.Scene, formulas: dict[str, Formula], monkeypatch: pytest.MonkeyPatch
) -> None:
    chosen = scene.replace({"numerics.face_slices": 70})
    tree = xr.DataTree(xr.Dataset(attrs={"scene_toml": chosen.to_toml()}))
    monkeypatch.setattr(import_module("semiwear.sweep.settled"), "simulate", lambda _: tree)
    formulas["/history/load_share_max"] = bowl
    asked = scene.replace({"numerics.accuracy": 0.05})
    best = sw.optimise(asked, {PINION: (0, 60)}, minimise="load_share_max", most=4, workers=0)
    assert best.scene.numerics.accuracy is None and best.scene.numerics.face_slices == 70
    assert at_resolution(best.scene, DOUBLED).numerics.face_slices == 140


def test_designs_that_cannot_be_solved_finely_are_told(
    scene: sw.Scene, formulas: dict[str, Formula], monkeypatch: pytest.MonkeyPatch
) -> None:
    known = designs_module.solve

    def solve(task: Task) -> Outcome:
        if task.scene.numerics.face_slices >= 61:
            return Outcome(task.key, Status.FAILED, "no load sharing")
        return known(task)

    solve_by(monkeypatch, solve)
    formulas["/history/load_share_max"] = bowl
    best = sw.optimise(scene, {PINION: (0, 60)}, minimise="load_share_max", most=6, workers=0)
    assert not best.kept and "NO design was found that can be solved finely" in str(best)
    assert "at twice the resolution (no load sharing)" in best.verdict and "unknown" in str(best)


def test_resolutions(scene: sw.Scene) -> None:
    coarse, own, doubled = (at_resolution(scene, name).numerics for name in (COARSE, OWN, DOUBLED))
    assert own == scene.numerics
    for name in ("face_slices", "roll_positions", "profile_points"):
        assert getattr(coarse, name) < getattr(own, name) < getattr(doubled, name)


@pytest.mark.slow
def test_relief_of_a_spur_pair_lowers_its_transmission_error() -> None:
    changes = {"wear.until.meshes": 2e7, "numerics.wear_steps": 1, "numerics.face_slices": 15}
    scene = sw.load_scene("spur_fzg_c").replace(changes)
    aim = "transmission_error_amplitude[unworn]"
    best = sw.optimise(scene, {PINION: (0, 40), GEAR: (0, 40)}, minimise=aim, most=20, workers=0)
    assert best.told[0].best < 0.9 * best.told[0].before
    assert sw.simulate(best.scene)["history"].transmission_error_amplitude.values[0] == pytest.approx(
        best.told[0].best
    )


def test_a_study_is_searched_written_and_reported(
    formulas: dict[str, Formula], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, unseen: None
) -> None:
    formulas["/history/wear_depth_max"] = bowl
    monkeypatch.setattr(command, "simulate", lambda scene: synthetic_tree(2, profiles=9, faces=7))
    study = tmp_path / "study.toml"
    study.write_text(
        'scene = "face_gear_25x160"\nminimise = "wear_depth_max"\nmost = 30\nset.wear.until.meshes = 1e6\n'
        f"[design]\n{PINION} = {{from = 0, to = 60}}\n{GEAR} = [0, 20]\n"
    )
    best, designs, page = (tmp_path / name for name in ("best.toml", "designs.nc", "best.html"))
    told = command.run_optimise(
        str(study), str(best), workers=0, designs=str(designs), report=str(page), progress=NoProgress()
    )
    assert "best design: least wear_depth_max" in told.text and told.best.kept
    scene = sw.load_scene(best)
    assert scene.effects.modification is not None
    assert scene.effects.modification.pinion.tip_relief_um == pytest.approx(42.0, abs=3.0)
    with xr.open_dataset(designs) as kept:
        assert kept["feasible"].values.all()
    assert page.read_text().count("<img") >= 5
    study.write_text(
        'scene = "face_gear_25x160"\nminimize = "wear_depth_max"\n[design]\nx = 3\n'
        "[design.operation]\npinion_torq = {from = 1, to = 2}\n[subject_to]\nwear_depth_mx = 3\n"
    )
    with pytest.raises(sw.SceneError) as caught:
        command.run_optimise(
            str(study), str(study), workers=0, designs=str(tmp_path / "away" / "designs.nc"), report="best.pdf",
            progress=NoProgress(),
        )  # fmt: skip
    for part in (
        "minimise", "both ends", "best.html", "--designs: found", "did you mean pinion_torque_Nm?",
        "did you mean wear_depth_max?",
    ):  # fmt: skip
        assert part in str(caught.value), part


def test_what_needs_no_scene_is_told_beside_one_that_cannot_be_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study = tmp_path / "study.toml"
    study.write_text(
        'scene = "no_such_scene"\nminimise = "wear_depth_mx"\nmost = 0\n[vary]\nx = [1]\n'
        "[design.operation]\npinion_torque_Nm = {from = 1}\npinion_sped_rpm = [1]\n[subject_to]\nload_share_max = 3\n"
    )
    assert main(["optimise", str(study), "-o", str(tmp_path / "best.toml"), "--workers", "-1"]) == 2
    told = capsys.readouterr().err
    for part in (
        "no file 'no_such_scene'", "did you mean wear_depth_max?", "most: found 0", "no [vary] beside [design]",
        "both ends", "subject_to", "workers", "did you mean pinion_speed_rpm?",
    ):  # fmt: skip
        assert part in told, part


def test_a_study_without_a_design_that_works_names_its_table(
    formulas: dict[str, Formula], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    formulas["/history/wear_depth_max"] = lambda x, y: np.nan
    fields = "\n".join(f"effects.modification.pinion.{name} = {{from = 1, to = 2}}" for name in RELIEFS)
    for design in (f"{PINION} = {{from = 0, to = 60}}", f"{fields}\n{fields.replace('pinion', 'gear')}"):
        study = tmp_path / "study.toml"
        study.write_text(f'scene = "face_gear_25x160"\nminimise = "wear_depth_max"\nmost = 4\n[design]\n{design}\n')
        assert main(["optimise", str(study), "-o", str(tmp_path / "best.toml"), "--workers", "0", "-q"]) == 2
        told = capsys.readouterr().err
        assert "1. design: found" in told and "vary:" not in told


def test_the_study_file_of_the_guide_can_run(formulas: dict[str, Formula], tmp_path: Path) -> None:
    guide = (Path(sw.__file__).parents[1] / "docs" / "best_designs.md").read_text(encoding="utf-8")
    (study,) = re.findall(r"```toml\n(.*?)```", guide, re.DOTALL)
    formulas["/history/wear_depth_max"] = bowl
    formulas["/history/transmission_error_amplitude"] = lambda x, y: 25.0
    (tmp_path / "study.toml").write_text("most = 12\n" + study)
    best = tmp_path / "best.toml"
    text = command.run_optimise(
        str(tmp_path / "study.toml"), str(best), workers=0, designs=None, report=None, progress=NoProgress()
    ).text
    assert "transmission_error_amplitude[worst]" in text and "<= 30" in text
    scene = sw.load_scene(best)
    assert scene.wear is not None and scene.wear.until.meshes == 2e7
    assert scene.gear_pair.pinion_tip_edge_radius_mm in (0.2, 0.4)


def test_machines_are_told_whether_limits_are_kept(
    formulas: dict[str, Formula], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    formulas["/history/wear_depth_max"] = bowl
    study = tmp_path / "study.toml"
    study.write_text(
        'scene = "face_gear_25x160"\nminimise = "wear_depth_max"\nmost = 4\nset.wear.until.meshes = 1e6\n'
        f'subject_to.wear_depth_max = "<= 1"\n[design]\n{PINION} = {{from = 0, to = 60}}\n'
    )
    assert main(["optimise", str(study), "-o", str(tmp_path / "best.toml"), "--workers", "0", "--json", "-q"]) == 0
    end = json.loads(capsys.readouterr().out)
    assert end["limits_kept"] is False and end["aims"] == ["least wear_depth_max"] and end["unsolved"] is None
    aim, limit = end["quantities"]
    assert aim["best"] == limit["best"] == pytest.approx(5.2, abs=0.5) and limit["limit"] == "wear_depth_max <= 1 um"
    assert list(end["changes"]) == [PINION]
