"""Emulators: a stated error that fresh runs keep, and what they are of without enough runs."""

import numpy as np
import pytest
from scipy.stats import binom, qmc

from semiwear.emulator import LEAST_RUNS, _fitted, emulator_of, kept_by


def bent(x: np.ndarray) -> np.ndarray:
    """Smooth in two inputs, with a kink in a third."""
    return np.exp(0.5 * x[:, 0] + 0.3 * x[:, 1]) + np.abs(0.2 + 0.6 * x[:, 2])


@pytest.mark.parametrize("runs", [32, pytest.param(64, marks=pytest.mark.slow)])
def test_fresh_runs_keep_the_stated_error(runs: int) -> None:
    """In 95 %: of eight designs' fresh runs together, as far as these tell (the error itself is from few runs)."""
    random, kept = np.random.default_rng(0), []
    for seed in range(8):
        inputs = 2.0 * qmc.Sobol(3, seed=seed).random(runs) - 1.0
        emulator = emulator_of(inputs, bent(inputs))
        fresh = random.uniform(-1.0, 1.0, (250, 3))
        kept.append(np.mean(np.abs(emulator.at(fresh) - bent(fresh)) <= emulator.error))
    assert np.mean(kept) >= 0.93


def test_more_runs_make_less_error() -> None:
    few, many = (emulator_of(x, bent(x)) for x in (2.0 * qmc.Sobol(3, seed=1).random(n) - 1.0 for n in (32, 128)))
    assert many.relative_error < 0.5 * few.relative_error


def test_the_relative_error_does_not_depend_on_the_unit() -> None:
    inputs = np.linspace(-1.0, 1.0, LEAST_RUNS)[:, None]
    values = np.abs(inputs[:, 0] - 0.1)
    plain, scaled = emulator_of(inputs, values), emulator_of(inputs, 1e3 * values)
    assert scaled.error == pytest.approx(1e3 * plain.error, rel=1e-6)
    assert scaled.relative_error == pytest.approx(plain.relative_error, rel=1e-6)


def test_it_is_the_mean_of_the_process_that_was_fitted() -> None:
    random = np.random.default_rng(2)
    inputs, fresh = random.uniform(-1.0, 1.0, (40, 3)), random.uniform(-1.0, 1.0, (20, 3))
    values = bent(inputs)
    process = _fitted(inputs, (values - values.mean()) / values.std())
    expected = values.mean() + values.std() * process.predict(fresh)
    np.testing.assert_allclose(emulator_of(inputs, values).at(fresh), expected, rtol=1e-8)


def test_a_left_out_run_is_predicted_by_the_others() -> None:
    """With the covariance of all runs, as it says."""
    random = np.random.default_rng(3)
    inputs = random.uniform(-1.0, 1.0, (30, 2))
    values = np.sin(2.0 * inputs[:, 0]) + inputs[:, 1] ** 2
    scaled = (values - values.mean()) / values.std()
    kernel = _fitted(inputs, scaled).kernel_
    covariance = kernel(inputs) + 1e-10 * np.eye(30)
    rest = np.arange(30) != 7
    predicted = covariance[7, rest] @ np.linalg.solve(covariance[np.ix_(rest, rest)], scaled[rest])
    found = emulator_of(inputs, values).left_out[7]
    assert found == pytest.approx(values[7] - values.mean() - values.std() * predicted, rel=1e-4, abs=1e-9)


def test_too_few_runs_state_no_error() -> None:
    random = np.random.default_rng(4)
    inputs = random.uniform(-1.0, 1.0, (LEAST_RUNS - 1, 1))
    assert emulator_of(inputs, inputs[:, 0] ** 2).error == np.inf
    assert kept_by(np.arange(float(LEAST_RUNS))) == LEAST_RUNS - 1.0


def test_the_stated_error_is_the_order_statistic_of_conformal_prediction() -> None:
    """With n errors of one distribution the rank that a fresh one keeps with 95 %: ceil(0.95 (n + 1))."""
    random = np.random.default_rng(5)
    count = sum(abs(random.standard_normal()) <= kept_by(random.standard_normal(39)) for _ in range(2000))
    assert binom.cdf(count, 2000, 0.95) > 0.001


def test_what_does_not_vary_has_no_error() -> None:
    emulator = emulator_of(np.linspace(-1.0, 1.0, 25)[:, None], np.full(25, 3.0))
    assert emulator.error == emulator.relative_error == 0.0
    np.testing.assert_array_equal(emulator.at(np.zeros((4, 1))), 3.0)
