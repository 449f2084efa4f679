"""Parts of an inference against closed forms: shapes, errors of runs left out, what an emulator's error makes."""

from collections.abc import Callable
from importlib import import_module

import numpy as np
import pytest

import semiwear as sw
from semiwear.errors import ConvergenceError, EndlessWearError, SemiwearError
from semiwear.inference.evidence import known_noise
from semiwear.inference.lives import PosteriorLife, life_of
from semiwear.inference.model import Model, Runs, model_of
from semiwear.inference.observations import Channel
from semiwear.inference.sampling import Target
from semiwear.inference.unknowns import COEFFICIENT, Unknowns, unknowns_of
from semiwear.sweep.measure import Measured
from tests.scenes import SHIPPED, TINY, UNTIL_MESHES

model, outcome = import_module("semiwear.inference.model"), import_module("semiwear.sweep.outcome")
RANDOM = np.random.default_rng(0)
LEVELS = np.linspace(0.0, 3.0, 4)
NO_MOVEMENTS = np.zeros((9, 0))
RUNS = Runs(
    RANDOM.uniform(-1.0, 1.0, (24, 2)), LEVELS, (RANDOM.normal(size=(24, 4, 9)), RANDOM.normal(size=(24, 4, 9)))
)


def channel(meshes: float = 1.0, movements: np.ndarray = NO_MOVEMENTS) -> Channel:
    nothing = np.zeros(movements.shape[0])
    return Channel("seen", meshes, "", nothing, "1", movements, lambda *_: nothing, lambda *_: known_noise(*_))


class Blind:
    """An emulator that tells zero whatever it knows: a run that is left out is missed by all of its value."""

    def __init__(self, inputs: np.ndarray, values: np.ndarray) -> None:
        self.left_out = values

    def at(self, inputs: np.ndarray) -> np.ndarray:
        return np.zeros(len(inputs))


@pytest.fixture
def blind(monkeypatch) -> Model:
    monkeypatch.setattr(model, "emulator_of", Blind)
    return model_of(RUNS, [channel(), channel()])


def test_an_emulator_that_knows_nothing_misses_what_differs_from_the_mean(blind):
    """Also what its components leave out."""
    for k, values in enumerate(RUNS.values):
        amounts = values @ blind.shapes[k]
        np.testing.assert_allclose(blind.left_out[..., blind.parts[k]], amounts - amounts.mean(axis=0), atol=1e-12)


def test_errors_are_the_mean_squares_of_the_runs_that_count_at_their_meshes(blind):
    """At a wear state, and half way between two of a number that is cubic in them."""
    near = np.arange(24) < 16
    for k, values in enumerate(RUNS.values):
        apart = (values - values.mean(axis=0)) @ blind.shapes[k]
        np.testing.assert_allclose(blind.error(k, 2.0), apart[:, 2].T @ apart[:, 2] / 24, rtol=1e-9)
        np.testing.assert_allclose(blind.error(k, 2.0, near), apart[near, 2].T @ apart[near, 2] / 16, rtol=1e-9)
    np.testing.assert_allclose(blind.weights(np.array([1.5])) @ LEVELS**3, 1.5**3)


def test_every_channel_is_read_at_its_own_meshes(blind):
    (first, second) = blind.amounts(np.zeros((2, 2)), np.array([[1.0, 3.0], [0.0, 2.0]]))
    for k, (found, states) in enumerate(zip((first, second), ([1, 0], [3, 2]), strict=True)):
        np.testing.assert_allclose(found, RUNS.values[k].mean(axis=0)[states] @ blind.shapes[k], atol=1e-12)


def test_shapes_are_free_of_what_a_datum_can_make_and_tell_all_else():
    movements = RANDOM.normal(size=(9, 2))
    (shapes,) = model_of(Runs(np.zeros((1, 0)), LEVELS, RUNS.values[:1]), [channel(movements=movements)]).shapes
    np.testing.assert_allclose(shapes.T @ movements, 0.0, atol=1e-12)
    np.testing.assert_allclose(shapes.T @ shapes, np.eye(7), atol=1e-12)


@pytest.mark.parametrize(("left", "count"), [(2.0, 1), (0.2, 1), (0.09, 2), (1e-3, 2), (5e-5, 3), (0.0, 3)])
def test_as_many_singular_values_are_kept_as_leave_little_enough(left, count):
    """Of 1, 0.1 and 1e-4 the first leaves about a tenth of the root of the sum of squares, two leave 1e-4."""
    assert model._count(np.array([1.0, 0.1, 1e-4]), left, 1.01) == count


# ---------------------------------------------------------------------- the density


class Straight(Target):
    """Amounts of each channel are linear in the unknowns."""

    slopes = (np.array([[1.0, 0.5], [0.3, -2.0]]), np.array([[0.7, 0.2]]))

    def amounts(self, normal: np.ndarray) -> list[np.ndarray]:
        return [normal @ one.T for one in self.slopes]


UNKNOWNS = unknowns_of({COEFFICIENT: sw.LogNormal(1e-13, 0.5), "operation.pinion_torque_Nm": sw.Normal(9, 1)}, 1e-13)
EVIDENCE = [
    known_noise(RANDOM.normal(size=12), RANDOM.normal(size=(12, count)), np.zeros((12, 0)), np.full(12, 1.5))
    for count in (2, 1)
]


def test_the_posterior_of_a_straight_model_is_normal_and_an_emulators_error_is_passed_on_by_slopes():
    """Precision 1 + sum S'WS, W what noise and emulator leave; an error moves it by the gain times the error."""
    target = Straight(UNKNOWNS, None, [channel(), channel()], EVIDENCE)  # type: ignore[arg-type]
    errors = [np.array([[0.3, 0.1], [0.1, 0.2]]), np.array([[0.4]])]
    precision, moved = np.eye(2), np.zeros((2, 2))
    for slopes, one, error in zip(target.slopes, EVIDENCE, errors, strict=True):
        weight = np.linalg.inv(np.linalg.inv(one.precisions[0]) + error)
        precision += slopes.T @ weight @ slopes
        moved += slopes.T @ weight @ error @ weight @ slopes
    covariance = np.linalg.inv(precision)
    expected = np.sqrt(np.diag(covariance @ moved @ covariance) / np.diag(covariance))
    np.testing.assert_allclose(target.emulator_shares(np.array([0.3, -0.2]), errors), expected, rtol=1e-9)
    # the same density, from its second differences
    steps = 0.1 * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1], [1, 0], [-1, 0], [0, 1], [0, -1], [0, 0]])
    told = Straight(UNKNOWNS, None, target.channels, [  # type: ignore[arg-type]
        one.widened(error) for one, error in zip(EVIDENCE, errors, strict=True)
    ]).log_density(steps)  # fmt: skip
    both = (told[0] - told[1] - told[2] + told[3]) / 0.04
    np.testing.assert_allclose(
        [(told[4] + told[5] - 2 * told[8]) / 0.01, (told[6] + told[7] - 2 * told[8]) / 0.01, both],
        [-precision[0, 0], -precision[1, 1], -precision[0, 1]], rtol=1e-6,
    )  # fmt: skip


def test_errors_of_an_emulator_are_looked_up_at_the_wear_of_a_place():
    """k N counts, and runs near the place alone where these are enough."""
    asked = []

    class Asked:
        runs = Runs(np.repeat([[-0.9], [0.1]], 16, axis=0), LEVELS, ())

        def error(self, channel: int, meshes: float, near: np.ndarray | None) -> np.ndarray:
            asked.append((channel, meshes, near))
            return np.zeros((1, 1))

    unknowns = Unknowns(UNKNOWNS.every, 5e-14)
    Target(unknowns, Asked(), [channel(1e8), channel(3e8)], []).emulator_errors(np.zeros(2))  # type: ignore[arg-type]
    assert [channel for channel, _, _ in asked] == [0, 1]
    assert [meshes for _, meshes, _ in asked] == pytest.approx([2e8, 6e8])
    for _, _, near in asked:
        assert near is not None and near.tolist() == 16 * [False] + 16 * [True]
    Asked.runs = Runs(Asked.runs.inputs[1:-1], LEVELS, ())
    Target(unknowns, Asked(), [channel()], []).emulator_errors(np.zeros(2))  # type: ignore[arg-type]
    assert asked[-1][2] is None


def test_every_channel_is_predicted_at_its_own_k_n():
    class Asked:
        def amounts(self, inputs: np.ndarray, meshes: np.ndarray) -> np.ndarray:
            return meshes

    target = Target(Unknowns(UNKNOWNS.every, 5e-14), Asked(), [channel(1e8), channel(3e8)], [])  # type: ignore[arg-type]
    np.testing.assert_allclose(target.amounts(np.zeros((3, 2))), 3 * [[2e8, 6e8]])


# ---------------------------------------------------------------------- lives

SPEED = "operation.pinion_speed_rpm"
LIVES = SHIPPED.replace({**TINY, **UNTIL_MESHES, "wear.until.meshes": 1e8, COEFFICIENT: 1e-13, SPEED: 1000.0})


SPEEDS = unknowns_of({SPEED: sw.Uniform(500.0, 3000.0)}, 1e-13)
DRAWS = np.random.default_rng(3).standard_normal((40, 1))
TOO_DEEP = ConvergenceError("too deep")


def lives_where(
    monkeypatch: pytest.MonkeyPatch, fails: Callable[[float], bool], error: SemiwearError = TOO_DEEP
) -> PosteriorLife:
    """Lives at 40 speeds, to which they are inverse, and at some of which they fail."""

    def life(task):
        speed = task.scene.operation.pinion_speed_rpm
        if fails(speed):
            raise error
        meshes = 2e11 / speed
        told = {"meshes_to_limit": meshes, "hours_to_limit": meshes / (60.0 * speed), "depth_limit": 20.0}
        return Measured({f"/life/{name}": np.array(value) for name, value in told.items()})

    monkeypatch.setattr(outcome, "_life", life)
    return life_of(LIVES, SPEEDS, DRAWS, (20.0, "gear", 0.0, 32), where=(0, None, None))


def test_a_few_lives_that_fail_are_left_out_and_the_hours_are_those_of_the_others(monkeypatch):
    speeds = SPEEDS.values(DRAWS)[:, 0]
    found = lives_where(monkeypatch, lambda speed: abs(speed - speeds[0]) < 1e-6)
    np.testing.assert_allclose(found.meshes, 2e11 / speeds, rtol=0.02)
    np.testing.assert_allclose(found.hours_per_mesh, 1.0 / (60.0 * speeds), rtol=1e-9)


def test_beside_lives_without_end_those_that_were_solved_have_the_hours_of_their_own_draws(monkeypatch):
    speeds = SPEEDS.values(DRAWS)[np.linspace(0, 39, 32).round().astype(int), 0]
    endless = (speeds > 2500.0) | (np.arange(32) < 4)
    found = lives_where(
        monkeypatch,
        lambda speed: np.abs(speeds[endless] - speed).min() < 1e-6,
        EndlessWearError("no end", life=True),
    )
    np.testing.assert_allclose(found.meshes, np.where(endless, np.inf, 2e11 / speeds), rtol=1e-9)
    np.testing.assert_allclose(found.hours_per_mesh, 1.0 / (60.0 * speeds), rtol=1e-9)


def test_many_lives_that_fail_are_told(monkeypatch):
    with pytest.raises(SemiwearError, match=r"\d+ of 32 lives cannot be found: .*too deep"):
        lives_where(monkeypatch, lambda speed: speed > 2500.0)
