"""Runs that are to be compared with one another: smooth, and with prisms of one Young's modulus."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest

import semiwear as sw
from semiwear.contact.plane_strain import plane_contact
from semiwear.contact.pressed_tips import pressed_tips
from semiwear.contact.slice_pressure import _EVEN, solve_slices
from semiwear.contact.smooth_ends import smooth_rate
from semiwear.meshing.flank_pair import DRIVEN
from semiwear.plan import Compared, plan
from semiwear.plan.straight import UnlikeError, on_line
from semiwear.simulate import simulate
from semiwear.wear.swept_line import own_wear, sweep

COARSE = {
    "numerics.face_slices": 7,
    "numerics.roll_positions": 8,
    "numerics.profile_points": 41,
    "numerics.harmonics": 3,
    "numerics.wear_steps": 1,
    "numerics.threads": 1,
    "wear.until.meshes": 1e7,
}
YOUNG = "material.gear.youngs_modulus_MPa"


@pytest.fixture(scope="module")
def scene() -> sw.Scene:
    return sw.load_scene("spur_fzg_c").replace(COARSE)


def last(scene: sw.Scene, compared: Compared | None) -> dict[str, np.ndarray]:
    history = simulate(scene, compared=compared)["history"].dataset.isel(wear_step=-1)
    return {str(name): values.values for name, values in history.data_vars.items()}


def test_prisms_of_another_modulus_are_scaled(scene: sw.Scene) -> None:
    stiffer = scene.replace({YOUNG: 1.1 * scene.material.gear.youngs_modulus_MPa})
    scaled, own = last(stiffer, Compared.with_runs_of(scene)), last(stiffer, Compared.with_runs_of(stiffer))
    for name, values in own.items():
        np.testing.assert_allclose(scaled[name], values, rtol=1e-6, err_msg=name)
    other = last(scene, Compared.with_runs_of(scene))
    assert not np.allclose(other["transmission_error_mean"], own["transmission_error_mean"], rtol=1e-3)


def test_a_smooth_run_is_that_of_the_scene(scene: sw.Scene) -> None:
    smooth, plain = last(scene, Compared.with_runs_of(scene)), last(scene, None)
    assert smooth.keys() == plain.keys()
    for name in ("wear_depth_max", "contact_pressure_pitch", "root_stress_max", "transmission_error_amplitude"):
        np.testing.assert_allclose(smooth[name], plain[name], rtol=0.01, err_msg=name)


@pytest.mark.parametrize(
    "key",
    [
        "material.gear.poissons_ratio",
        pytest.param("gear_pair.pinion_face_width_mm", marks=pytest.mark.slow),
    ],
)
def test_prisms_on_a_line_are_those_of_the_gears(scene: sw.Scene, key: str) -> None:
    group, *rest = key.split(".")
    at = getattr(scene, group)
    for name in rest:
        at = getattr(at, name)
    moved, beside = (scene.replace({key: at * (1.0 + change)}) for change in (0.01, 0.001))
    compared = Compared.with_runs_of(scene)
    base, own = last(scene, compared), last(moved, compared)
    read = last(moved, compared.along(scene, beside, 10.0))
    for name in ("wear_depth_max", "contact_pressure_pitch", "root_stress_max", "transmission_error_mean"):
        change = np.abs(own[name] - base[name]).max()
        assert change > 0.0
        # a straight line over a step of 1 % leaves its square, and the line is through a tenth of the step
        assert np.abs(read[name] - own[name]).max() <= 0.02 * change, name


def test_fields_that_prisms_do_not_depend_on_have_no_course(scene: sw.Scene) -> None:
    compared = Compared.with_runs_of(scene)
    heavier = scene.replace({"operation.pinion_torque_Nm": 1.01 * scene.operation.pinion_torque_Nm})
    stiffer = scene.replace({YOUNG: 1.01 * scene.material.gear.youngs_modulus_MPa})
    assert compared.along(scene, heavier, 10.0) is compared
    assert compared.along(scene, stiffer, 10.0) is compared


def test_prisms_are_of_each_body_at_the_moduli_of_the_scene_compared_with(scene: sw.Scene) -> None:
    """A bronze gear under a steel pinion, beside stiffer ones: only Young's moduli are those of the former."""
    bronze = {"material.gear.youngs_modulus_MPa": 115000.0, "material.gear.poissons_ratio": 0.34}
    other = {"material.pinion.youngs_modulus_MPa": 2.1e5, "material.gear.youngs_modulus_MPa": 1.2e5}
    scene = scene.replace(bronze | {"material.pinion.poissons_ratio": 0.3})
    stiffer = scene.replace(other)
    beside = stiffer.replace({"material.gear.poissons_ratio": 0.35, "gear_pair.pinion_face_width_mm": 15.0})
    steel = scene.material.pinion.youngs_modulus_MPa
    course = Compared.with_runs_of(scene).along(stiffer, beside, 3.0).course
    assert course is not None and course.share == 3.0
    for end, of, ratio in ((course.at, stiffer, 0.34), (course.beside, beside, 0.35)):
        assert end.gears == of.gear_pair
        assert [body.youngs_modulus_MPa for body in end.materials] == [steel, 115000.0]
        assert [body.poissons_ratio for body in end.materials] == [0.3, ratio]


class _Pair(NamedTuple):
    one: float
    other: np.ndarray


@dataclass(frozen=True)
class _Made:
    name: str
    count: int
    pairs: tuple[_Pair, ...]


def test_a_line_goes_through_numbers_and_arrays_alone() -> None:
    def made(value: float, count: int = 2, places: int = 3) -> _Made:
        return _Made("tooth", count, (_Pair(value, np.full(places, 2.0 * value)),))

    found = on_line(made(1.0), made(1.5), -2.0)
    assert found.pairs[0].one == 0.0
    np.testing.assert_array_equal(found.pairs[0].other, 0.0)
    assert found.name == "tooth"
    for unlike in (made(1.5, count=3), made(1.5, places=4)):
        with pytest.raises(UnlikeError):
            on_line(made(1.0), unlike, 0.5)


def test_lines_that_come_into_contact_are_felt_by_and_by(scene: sw.Scene) -> None:
    teeth = plan(scene.replace({"numerics.roll_positions": 64})).loaded_teeth()  # footprints overlap
    state = teeth.load(np.zeros(teeth.grid.profile.shape))
    motion = sweep(teeth.lines, state.coarse.profile, teeth.pair.roll_per_time)
    rotation = np.tile(state.loads.rotation, teeth.rolls.pairs)
    distance = state.coarse.gap - rotation[:, None] * teeth.lines.lever_arm

    def greatest_step(fades: float, count: int) -> float:
        growths = np.linspace(0.0, 0.01, count)  # mm
        found = [own_wear(teeth.lines, motion, state.coarse, distance, growth, DRIVEN, fades) for growth in growths]
        return float(np.abs(np.diff(found, axis=0)).max())

    # steps that are half as long change half as much where there is no jump, and as much across one
    assert greatest_step(0.0, 201) == pytest.approx(greatest_step(0.0, 401), rel=1e-9)
    assert greatest_step(0.01, 401) < 0.6 * greatest_step(0.01, 201)


def test_the_contact_of_a_pressed_edge_changes_by_and_by_with_its_load(scene: sw.Scene) -> None:
    teeth = plan(scene).loaded_teeth()
    state = teeth.load(np.zeros(teeth.grid.profile.shape))
    load = np.where(pressed_tips(teeth, state).any(axis=0), teeth.problem.line_load(state.loads), 0.0)
    assert np.count_nonzero(load) > 3

    def greatest_change(count: int) -> float:
        shares = np.linspace(1.0, 1.04, count)
        found = [
            solve_slices(teeth.lines, state.coarse, share * load, teeth.problem.modulus, 0.0, smooth=True)[
                1
            ].curvature[load > 0.0]
            for share in shares
        ]
        return float(np.abs(np.diff(np.log(found), axis=0)).max())

    # a band of cells that began and ended at points of the outline would jump by a share of itself
    assert greatest_change(321) < 0.6 * greatest_change(161)


def test_a_corner_that_presses_with_one_cell_after_another_yields_smoothly() -> None:
    count, load = 32, 40.0
    cells = np.arange(count)

    def rates(corner: float) -> tuple[float, float]:
        """Change of the approach by the load, of whole cells and smoothly, with a corner beside a round body."""
        gap = np.minimum(0.9 * (cells - 10.0) ** 2, 20.0 + 40.0 * np.abs(cells - corner))
        active, force = gap < load, np.empty(count)
        work = np.empty((count, count)), np.empty(count), np.empty(count), np.empty(count, dtype=np.int64)
        approach, rate = plane_contact(gap, load, _EVEN, active, force, *work)
        assert active[24:].any() and active[24:].sum() <= 2
        pressed = np.empty(count, dtype=bool)
        return rate, smooth_rate(gap, _EVEN.influence, approach, rate, active, force, *work, pressed, count)

    whole, smooth = np.array([rates(corner) for corner in np.linspace(25.2, 26.8, 801)]).T
    assert np.abs(np.diff(whole)).max() > 0.08
    assert np.abs(np.diff(smooth)).max() < 3e-3
