"""Sensitivities of quantities that are known formulas of the fields, and of a worn scene."""

from collections.abc import Callable
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import semiwear as sw
from semiwear import sensitivities as public
from semiwear.plan import Compared, plan
from semiwear.sweep.measure import Measured
from semiwear.sweep.outcome import Outcome, Status
from semiwear.sweep.scenes import Task
from semiwear.wear.stepping import _Step

TORQUE, YOUNG = "operation.pinion_torque_Nm", "material.gear.youngs_modulus_MPa"
OFFSET = "effects.misalignment.offset_mm"
COEFFICIENT = "wear.coefficient_mm2_per_N"
MODULE = import_module("semiwear.sensitivities")  # of the same name as its function
PROCESSES = import_module("semiwear.sweep.processes")


@pytest.fixture
def scene(shipped: sw.Scene) -> sw.Scene:
    return shipped.replace({"wear.until.meshes": 1e6})


@pytest.fixture
def by_formula(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[[sw.Scene], float]], None]:
    """Let a formula of the scene stand for the greatest wear."""

    def use(formula: Callable[[sw.Scene], float]) -> None:
        def solve(task: Task) -> Outcome:
            assert task.compared is not None
            value = formula(task.scene)
            if not np.isfinite(value):
                return Outcome(task.key, Status.FAILED, "teeth lose contact")
            return Outcome(
                task.key, Status.DONE, measured=Measured({"/history/wear_depth_max": np.array([0.0, value])})
            )

        for module in (MODULE, PROCESSES):
            monkeypatch.setattr(module, "solve", solve)

    return use


def torque(scene: sw.Scene) -> float:
    return scene.operation.pinion_torque_Nm / 1600.0


def test_the_package_gives_the_function():
    assert callable(public)
    assert sw.sensitivities is public


def test_smooth_quantities(scene: sw.Scene, by_formula: Callable) -> None:
    by_formula(lambda s: 3.0 * torque(s) ** 1.7 / (s.material.gear.youngs_modulus_MPa / 207000.0) ** 0.4)
    found = public(scene, "wear_depth_max", [TORQUE, YOUNG], workers=0)
    # two runs a field: a central difference of 1 % steps is off by its square
    np.testing.assert_allclose(found["relative"].values, [[1.7, -0.4]], rtol=1e-4)
    np.testing.assert_allclose(found["derivative"].values[0, 0], 3.0 * 1.7 / 1600.0, rtol=1e-4)
    off = np.abs(found["derivative"].values[0] - np.array([3.0 * 1.7 / 1600.0, -0.4 * 3.0 / 207000.0]))
    assert (off <= found["error"].values[0]).all()
    assert (found["runs"] == 2).all()
    assert not found["doubtful"].any()
    assert not found["kink"].any()
    assert (found["error"].values <= 1e-2 * np.abs(found["derivative"].values)).all()
    assert found["value"].values[0] == pytest.approx(3.0)
    assert (found["message"] == "").all()


def test_scatter_and_bends_take_a_second_pair_and_are_told(scene: sw.Scene, by_formula: Callable) -> None:
    by_formula(lambda s: 1.0 + 0.1 * (torque(s) - 1.0) + 1e-3 * np.sin(7.3e3 * torque(s)))
    found = public(scene, "wear_depth_max", [TORQUE], workers=0)
    assert found["runs"].values[0] == 4
    assert found["doubtful"].all()


def test_a_quantity_that_the_result_lacks_is_told(scene: sw.Scene) -> None:
    with pytest.raises(sw.SceneError, match="its result has no meshes_to_limit"):
        public(scene, "meshes_to_limit", [TORQUE], workers=0)


def test_a_quantity_that_is_no_text_is_told_with_the_fields(scene: sw.Scene) -> None:
    with pytest.raises(sw.SceneError, match=r"of: found 5(.|\n)*workers: found -1"):
        public(scene, 5, [TORQUE], workers=-1)


def test_a_field_that_no_scene_has_is_called_one(scene: sw.Scene) -> None:
    with pytest.raises(sw.SceneError) as caught:
        public(scene, "wear_depth_max", ["operation.pinion_torq", "foo", "effects.modification.pinion.tip_relief_um"])
    told = str(caught.value)
    assert "3 problems" in told and "did you mean pinion_torque_Nm?" in told
    assert "found 'foo'" in told and "give the scene a value" in told


def test_wear_coefficient_and_meshes_share_runs_or_take_none(scene: sw.Scene, by_formula: Callable) -> None:
    def worn(one: sw.Scene) -> float:
        assert one.wear is not None
        return (one.wear.coefficient_mm2_per_N * 1e13) ** 0.8  # type: ignore[operator]

    by_formula(worn)
    found = public(scene, "wear_depth_max", [COEFFICIENT, "wear.until.meshes"], workers=0)
    np.testing.assert_allclose(found["relative"].values, 0.8, rtol=1e-4)
    assert found["runs"].values.tolist() == [2, 0]
    to_depth = scene.replace({"wear.until.meshes": None, "wear.until.control_depths_um": [10, 20]})
    found = public(to_depth, "wear_depth_max", [COEFFICIENT], workers=0)
    assert found["runs"].values.tolist() == [0]
    assert found["relative"].values[0, 0] == 0.0
    assert found["error"].values[0, 0] == 0.0
    assert not found["doubtful"].any()


def test_errors_have_the_scatter_between_runs(scene: sw.Scene, by_formula: Callable) -> None:
    by_formula(lambda s: 2.0 + torque(s))
    found = public(scene, "wear_depth_max", {TORQUE: 1.6}, workers=0)
    # 5e-10 of the value over a step of 1e-3, and 2e-3 of the derivative
    np.testing.assert_allclose(found["error"].values, 3.0 * 5e-10 / 1.6 + 2e-3 / 1600.0, rtol=1e-3)
    assert not found["doubtful"].any()


@given(st.lists(st.floats(-3.0, 3.0), min_size=5, max_size=5))
def test_polynomials_of_the_fourth_degree_are_exact(coefficients: list[float]) -> None:
    x, h = 0.7, 0.01
    f = np.polynomial.Polynomial(coefficients)
    slope, error, _ = MODULE._slopes({side: f(x + side * h) for side in (-2, -1, 1, 2)}, f(x), h)
    assert slope == pytest.approx(f.deriv()(x), abs=1e-10)
    assert error >= 0.0


@given(st.floats(-1.99, 1.99), st.floats(0.01, 10.0), st.sampled_from([-1.0, 1.0]))
def test_a_kink_anywhere_in_the_steps_is_in_the_error(place: float, change: float, sign: float) -> None:
    """Four values in a row hide one in the middle of a step, and the ratio of two bends one beyond it."""

    def f(x: float) -> float:
        return x + sign * change * max(x - place, 0.0)

    slope, error, _ = MODULE._slopes({side: f(side) for side in (-2, -1, 1, 2)}, f(0.0), 1.0)
    truth = 1.0 + sign * change * float(np.heaviside(-place, 0.5))
    assert abs(slope - truth) <= error * (1.0 + 1e-6) + 1e-12


@given(st.lists(st.floats(-3.0, 3.0), min_size=4, max_size=4), st.sampled_from([1, -1]))
def test_polynomials_of_the_third_degree_are_exact_by_three_runs(coefficients: list[float], sign: int) -> None:
    x, h = 0.7, 0.01
    f = np.polynomial.Polynomial(coefficients)
    slope, error, kink = MODULE._slopes({side: f(x + side * h) for side in (-1, 1, 2 * sign)}, f(x), h)
    assert slope == pytest.approx(f.deriv()(x), abs=1e-10)
    assert error >= 0.0 and not kink


def test_an_even_bend_takes_three_runs(scene: sw.Scene, by_formula: Callable) -> None:
    by_formula(lambda s: torque(s) ** 8)
    found = public(scene, "wear_depth_max", {TORQUE: 16.0}, workers=0)
    assert found["runs"].values.tolist() == [3]
    assert found["relative"].values[0, 0] == pytest.approx(8.0, rel=1e-4)
    assert not found["doubtful"].any()


def test_a_kink_is_told_and_a_bend_is_none(scene: sw.Scene, by_formula: Callable) -> None:
    by_formula(lambda s: 1.0 + max(torque(s) - 1.0, 0.0))
    assert public(scene, "wear_depth_max", [TORQUE], workers=0)["kink"].all()
    by_formula(lambda s: 1.0 + 0.01 * (torque(s) - 1.0) + 5.0 * (torque(s) - 1.0) ** 2)
    assert not public(scene, "wear_depth_max", [TORQUE], workers=0)["kink"].any()


def test_a_kink_between_one_step_and_two_is_told(scene: sw.Scene, by_formula: Callable) -> None:
    by_formula(lambda s: torque(s) + 3.0 * (torque(s) - 1.0) ** 2 + 5.0 * max(torque(s) - 1.015, 0.0))
    found = public(scene, "wear_depth_max", {TORQUE: 16.0}, workers=0)
    assert found["kink"].all() and found["doubtful"].all()
    assert found["error"].values[0, 0] > abs(found["derivative"].values[0, 0] - 1.0 / 1600.0)


def test_one_side_will_do_and_none_is_told(scene: sw.Scene, by_formula: Callable) -> None:
    by_formula(lambda s: torque(s) ** 2 if torque(s) <= 1.0 else np.nan)
    found = public(scene, "wear_depth_max", [TORQUE], workers=0)
    assert found["relative"].values[0, 0] == pytest.approx(2.0, abs=1e-9)
    assert found["message"].values[0] == "teeth lose contact"
    by_formula(lambda s: 1.0 if torque(s) == 1.0 else np.nan)
    found = public(scene, "wear_depth_max", [TORQUE], workers=0)
    assert np.isnan(found["derivative"].values).all()
    assert found["message"].values[0] == "teeth lose contact"
    by_formula(lambda s: np.nan)
    with pytest.raises(sw.SemiwearError, match="teeth lose contact"):
        public(scene, "wear_depth_max", [TORQUE], workers=0)


def test_a_quantity_that_hardly_depends_on_the_field_takes_two_runs(scene: sw.Scene, by_formula: Callable) -> None:
    by_formula(lambda s: 1.0 + 1e-5 * (torque(s) - 1.0) + 1e-3 * (torque(s) - 1.0) ** 2)
    found = public(scene, "wear_depth_max", [TORQUE], workers=0)
    assert found["runs"].values.tolist() == [2]
    assert not found["doubtful"].any()
    by_formula(lambda s: 1.0 + 1e-5 * (torque(s) - 1.0) + 0.1 * abs(torque(s) - 1.0))
    assert public(scene, "wear_depth_max", [TORQUE], workers=0)["doubtful"].all()


def test_a_small_derivative_is_doubtful_where_its_error_is_not_small_beside_it(
    scene: sw.Scene, by_formula: Callable
) -> None:
    for slope, doubtful in ((3e-4, True), (1e-3, False)):  # scatter between runs: 5e-6 in `relative`
        by_formula(lambda s, slope=slope: 1.0 + slope * (torque(s) - 1.0))
        found = public(scene, "wear_depth_max", [TORQUE], workers=0)
        assert found["relative"].values[0, 0] == pytest.approx(slope)
        assert found["doubtful"].values[0, 0] == doubtful


def test_steps_of_their_own(scene: sw.Scene, by_formula: Callable) -> None:
    by_formula(lambda s: 1.0 + (0.0 if s.effects.misalignment is None else s.effects.misalignment.offset_mm))
    found = public(scene, "wear_depth_max", {OFFSET: 0.02}, workers=0)
    assert found["derivative"].values[0, 0] == pytest.approx(1.0)
    assert found["step"].values[0] == 0.02


def test_all_that_is_wrong_is_told_at_once(scene: sw.Scene) -> None:
    with pytest.raises(sw.SceneError) as caught:
        public(
            scene, "wear_depht_max", [OFFSET, "gear_pair.pinion_teeth", "operation.pinion_torqe_Nm", "gear_pair.type"]
        )
    for part in ("wear_depth_max", "a step in a mapping", "any number", "pinion_torque_Nm", "field that is a number"):
        assert part in str(caught.value), part


@pytest.mark.slow
def test_meshes_to_a_depth_are_inverse_to_the_wear_coefficient(small: sw.Scene) -> None:
    scene = small.replace({"wear.until.control_depths_um": [5, 10]})
    found = public(scene, ["wear_volume[gear]", "root_stress_max[gear]"], ["wear.coefficient_mm2_per_N", TORQUE])
    # to a depth the worn shape does not know the coefficient
    assert np.abs(found["relative"].sel(field="wear.coefficient_mm2_per_N")).max() < 1e-6
    heavier, lighter = (scene.replace({TORQUE: 1600.0 + change}) for change in (5.0, -5.0))
    stress = [
        sw.simulate(one)["history"]["root_stress_max"].sel(body="gear").values[-1] for one in (heavier, lighter)
    ]
    slope = float(found["derivative"].sel(field=TORQUE, quantity="root_stress_max[gear]"))
    assert slope == pytest.approx((stress[0] - stress[1]) / 10.0, rel=0.02)


@pytest.mark.slow
def test_derivatives_do_not_hang_on_the_step() -> None:
    """Pressed tips yield in steps of a cell where runs are not smooth: slopes of this scene then differ by 1 %."""
    coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 16, "numerics.profile_points": 71}
    worn = {"wear.until.meshes": 6e7, "numerics.wear_steps": 3, "operation.pinion_torque_Nm": 360.0}
    scene = sw.load_scene("spur_fzg_c").replace(coarse | worn)
    names = ["wear_depth_max[gear]", "root_stress_max[gear]", "transmission_error_amplitude"]
    slopes = [public(scene, names, {TORQUE: step}, workers=0) for step in (0.7, 3.6)]
    np.testing.assert_allclose(slopes[0]["relative"], slopes[1]["relative"], rtol=3e-3)
    assert not any(one["doubtful"].any() for one in slopes)


def test_an_edge_that_just_cuts_off_a_footprint_is_felt_by_and_by(small: sw.Scene) -> None:
    physics = replace(plan(small), compared=Compared.with_runs_of(small))
    teeth = physics.loaded_teeth()
    loads = teeth.load(np.zeros(teeth.grid.profile.shape)).loads
    worn = teeth.touch_solved(np.zeros(teeth.grid.profile.shape))
    gaps = [
        teeth.fidelity.with_edges(teeth.problem, replace(worn, cut=share * worn.edge), loads, worn).gap
        for share in (0.0, 1e-6, 1.0)
    ]
    changed = gaps[2] != worn.gap
    assert changed.any() and (gaps[0] == worn.gap).all()
    little, all_of_it = (np.abs(gap[changed] - worn.gap[changed]).max() for gap in gaps[1:])
    assert little < 1e-5 * all_of_it


def test_an_edge_that_just_comes_near_is_felt_by_and_by(small: sw.Scene) -> None:
    teeth = replace(plan(small), compared=Compared.with_runs_of(small)).loaded_teeth()
    loads = teeth.load(np.zeros(teeth.grid.profile.shape)).loads
    worn = teeth.touch_solved(np.zeros(teeth.grid.profile.shape))
    edge = np.argwhere(teeth.fidelity.with_edges(teeth.problem, worn, loads, worn).gap != worn.gap)[0]
    roll, face = map(int, edge)
    touches = worn.least[roll, face] / teeth.lines.lever_arm[roll, face]

    def moved(nearer: float) -> float:
        """How far the edge is moved where it is nearer than it touches by so much [mm]."""
        rotation = np.full_like(loads.rotation, touches + nearer / teeth.lines.lever_arm[roll, face])
        touched = teeth.fidelity.with_edges(teeth.problem, worn, replace(loads, rotation=rotation), worn)
        return float(abs(touched.gap[roll, face] - worn.gap[roll, face]))

    approach = teeth.problem.typical_approach
    assert moved(-1e-6 * approach) == 0.0
    assert 0.0 < moved(1e-6 * approach) < 1e-4 * moved(approach)


def test_a_slice_that_comes_to_bear_is_felt_by_and_by(small: sw.Scene) -> None:
    """A power of the pressure is far from 1 under the least load; a median is of one slice more."""
    law = {"effects.wear_law.load": {"exponent": 0.8, "reference_pressure_MPa": 1000.0}}
    scene = small.replace(law)
    physics = replace(plan(scene), compared=Compared.with_runs_of(scene))
    teeth = physics.loaded_teeth()
    stepper = physics.wear_stepper(teeth)
    start = stepper.start()
    force = start.contact.loads.force
    unloaded = np.nonzero((force == 0.0) & np.isfinite(teeth.lines.separation[0]))

    def predicted(share: float) -> tuple[np.ndarray, np.ndarray]:
        """Factors on the wear coefficient, and wear, where unloaded slices bear a share of the greatest force."""
        pressed, width = force.copy(), start.contact.loads.half_width.copy()
        pressed[unloaded], width[unloaded] = share * force.max(), np.sqrt(share) * width.max()
        loads = replace(start.contact.loads, force=pressed, half_width=width)
        step = _Step(stepper, replace(start, contact=replace(start.contact, loads=loads)))
        factor = step.cases[0].factor
        assert factor is not None
        told = factor.copy()
        return told, step.predict_wear(1e9, 1e9).driven

    factors, depths = zip(*(predicted(share) for share in (0.0, 1e-9, 1e-3)), strict=True)
    changed = [np.abs(one - factors[0]).max() for one in factors[1:]]
    assert changed[0] < 1e-5 and changed[1] > 0.5
    np.testing.assert_allclose(depths[1], depths[0], rtol=0.0, atol=1e-7 * depths[0].max())
