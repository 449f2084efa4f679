"""The amplitude of the transmission error does not hang on where roll positions fall."""

from importlib import import_module
from typing import Any

import numpy as np
import pytest

import semiwear as sw
from semiwear.accuracy import run
from semiwear.optimise.designs import COARSE, DOUBLED, OWN, Aim, Designs
from semiwear.optimise.quantity import measure_of_quantities, quantity_of
from semiwear.optimise.space import space_of
from semiwear.report.numbers import _excitation
from semiwear.scene import parse_scene
from semiwear.sweep.outcome import solve
from semiwear.sweep.scenes import Task
from tests.same_result import different_variables

_PINION, _GEAR = (f"effects.modification.{body}.tip_relief_um" for body in ("pinion", "gear"))
_GRID = {
    "numerics.face_slices": 7, "numerics.roll_positions": 12, "numerics.harmonics": 5, "numerics.profile_points": 61,
}  # fmt: skip
_AMPLITUDE = "/history/transmission_error_amplitude"
_SCENE = ("attribute scene_sha256", "attribute scene_toml")


@pytest.fixture(scope="module")
def relieved() -> sw.Scene:
    """A spur pair whose least transmission error, where its pairs change, lies between two of twelve positions."""
    changes = {"operation.pinion_torque_Nm": 100.0, "wear.until.meshes": 2e7, "numerics.wear_steps": 1}
    return sw.load_scene("spur_fzg_c").replace(_GRID | changes | {_PINION: 40.0, _GEAR: 40.0})


@pytest.fixture(scope="module")
def plain(relieved: sw.Scene) -> Any:
    return sw.simulate(relieved)


@pytest.fixture(scope="module")
def dense(relieved: sw.Scene, plain: Any) -> np.ndarray:
    """Amplitudes of both wear states at 384 even positions."""
    worn = plain["flank"].wear_depth
    cycles = (sw.loaded_contact(relieved, np.arange(384) / 384, worn.isel(wear_step=k))["mesh_cycle"] for k in (0, 1))
    return np.array([np.ptp(cycle.transmission_error_loaded.values) for cycle in cycles])


@pytest.mark.parametrize(("positions", "within"), [(48, 0.12), (192, 0.025), (384, 0.002)])
def test_peaks_between_positions_are_found(
    relieved: sw.Scene, plain: Any, dense: np.ndarray, positions: int, within: float
) -> None:
    found = sw.simulate(relieved.replace({"numerics.peak_positions": positions}))
    amplitude = found["history"].transmission_error_amplitude.values
    assert (plain["history"].transmission_error_amplitude.values < 0.85 * dense).all()
    np.testing.assert_allclose(amplitude, dense, rtol=within)
    assert different_variables(plain, found) == [_AMPLITUDE, *_SCENE]


def test_results_sweeps_and_reports_say_that_roll_positions_miss_peaks(relieved: sw.Scene, plain: Any) -> None:
    swept = sw.sweep(relieved, {"operation.pinion_torque_Nm": [100.0]}, measure=_AMPLITUDE[9:], workers=0)
    for amplitude in (plain["history"].transmission_error_amplitude, swept.transmission_error_amplitude):
        assert "numerics.peak_positions (192 is usual) finds the peaks" in amplitude.attrs["comment"]
    known = plain.copy()
    known.attrs["scene_toml"] = relieved.replace({"numerics.peak_positions": 192}).to_toml()
    for tree, told in ((plain, True), (known, False)):
        (note,) = (note for name, _, note in _excitation(tree) if name == "Transmission error, amplitude")
        assert ("numerics.peak_positions finds peaks between them" in note) == told


def test_even_positions_that_are_near_enough_stay_alone(relieved: sw.Scene, plain: Any) -> None:
    found = sw.simulate(relieved.replace({"numerics.peak_positions": 12}))
    amplitudes = (one["history"].transmission_error_amplitude.values for one in (found, plain))
    np.testing.assert_allclose(*amplitudes, rtol=1e-12)


def test_a_search_for_a_design_knows_what_its_positions_miss(relieved: sw.Scene, dense: np.ndarray) -> None:
    vary = {_PINION: (0.0, 80.0), _GEAR: (0.0, 80.0)}
    quantity = quantity_of("minimise", "transmission_error_amplitude[unworn]", [])
    assert quantity is not None
    designs = Designs(relieved, space_of(relieved, vary), (Aim(quantity),), (), 0, lambda _: None)
    place = [np.array([0.5, 0.5])]
    coarse, own, doubled = (designs.solved(place, name)[0].aims[0] for name in (COARSE, OWN, DOUBLED))
    assert own < 0.85 * dense[0]
    assert coarse == pytest.approx(dense[0], rel=0.025)
    assert doubled == pytest.approx(dense[0], rel=0.01)
    assert designs.scene_of(place[0], OWN).numerics == relieved.numerics


@pytest.mark.parametrize(
    ("asked", "states"),
    [(["[unworn]"], [0]), (["[unworn]", ""], [0, 1]), (["[worst]"], [0, 1]), ([""], [1]), ([], [])],
)
def test_peaks_are_found_in_the_wear_states_that_are_asked_for(
    relieved: sw.Scene, monkeypatch: pytest.MonkeyPatch, asked: list[str], states: list[int]
) -> None:
    scene = relieved.replace({"numerics.peak_positions": 48})
    whole = sw.simulate(scene)["history"].transmission_error_amplitude.values
    found: list[float] = []
    module = import_module("semiwear.simulate")
    own = module.error_amplitude
    monkeypatch.setattr(module, "error_amplitude", lambda *given: found.append(own(*given)) or found[-1])
    names = [f"transmission_error_amplitude{time}" for time in asked] + ["wear_depth_max[worst]"]
    quantities = [quantity for name in names if (quantity := quantity_of("minimise", name, []))]
    solved = solve(Task("", scene, measure_of_quantities(quantities)))
    np.testing.assert_array_equal(found, whole[states])
    values = [quantity.value(solved.measured, low_is_good=True) for quantity in quantities[:-1]]
    expected = {"[unworn]": whole[0], "": whole[-1], "[worst]": whole.max()}
    assert values == [expected[time] for time in asked]


@pytest.mark.slow
def test_an_accuracy_finds_peaks_of_all_states_and_compares_the_first_and_the_last(
    relieved: sw.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    chosen = {f"numerics.{name}": None for name in ("face_slices", "roll_positions", "harmonics", "profile_points")}
    found: list[int] = []
    module = import_module("semiwear.simulate")
    own = module.error_amplitude
    monkeypatch.setattr(module, "error_amplitude", lambda *given: found.append(0) or own(*given))
    given = run.simulate_as_given
    calls: list[tuple[int, int]] = []

    def counted(scene: sw.Scene, **options: Any) -> Any:
        found.clear()
        tree = given(scene, **options)
        calls.append((len(found), tree["history"].sizes["wear_step"]))
        return tree

    monkeypatch.setattr(run, "simulate_as_given", counted)
    scene = relieved.replace(chosen | {"numerics.accuracy": 0.1, "numerics.wear_steps": 3})
    tree = sw.simulate(scene)
    *coarse, last = calls
    assert last == (4, 4)
    assert [peaks for peaks, _ in coarse] == 6 * [2]
    assert min(states for _, states in coarse) == 4
    assert float(tree["diagnostics"].error_estimate.sel(quantity="transmission_error_amplitude")) <= 0.1
    finer = parse_scene(tree.attrs["scene_toml"]).replace(
        {
            "numerics.accuracy": None,
            "numerics.roll_positions": 96,
            "numerics.face_slices": 41,
            "numerics.harmonics": 33,
        }
    )
    exact = given(finer)["history"].transmission_error_amplitude
    apart = np.abs(tree["history"].transmission_error_amplitude - exact)
    assert float(apart.max() / abs(exact).max()) <= 0.1


def test_a_search_for_other_quantities_spares_the_peaks(relieved: sw.Scene) -> None:
    quantity = quantity_of("minimise", "wear_depth_max", [])
    assert quantity is not None
    designs = Designs(relieved, space_of(relieved, {_PINION: (0, 80)}), (Aim(quantity),), (), 0, lambda _: None)
    assert designs.scene_of(np.array([0.5]), DOUBLED).numerics.peak_positions is None


@pytest.mark.parametrize(("changes", "positions"), [({}, 267), ({"numerics.peak_positions": 50}, 50)])
def test_an_accuracy_asks_for_peaks(
    relieved: sw.Scene, monkeypatch: pytest.MonkeyPatch, changes: dict[str, int], positions: int
) -> None:
    class Search:
        def __init__(self, scene: sw.Scene, _: object) -> None:
            self.scene = scene

        def run(self, *_: object) -> sw.Scene:
            return self.scene

    monkeypatch.setattr(run, "_Search", Search)
    found: Any = sw.simulate(relieved.replace({"numerics.accuracy": 0.03} | changes))
    assert found.numerics.peak_positions == positions
