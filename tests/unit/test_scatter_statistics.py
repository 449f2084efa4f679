"""Statistics of samples that are given: wider by errors of emulated ones, from the first ones, of a paired study."""

from importlib import import_module

import numpy as np
import pytest
import xarray as xr

from semiwear.emulator import kept_by
from semiwear.errors import Problem
from semiwear.scatter import estimates
from semiwear.scatter.design import read_correlation
from semiwear.scatter.statistics import Scatter, end_text, varies
from semiwear.sweep.outcome import Status

emulated = import_module("semiwear.scatter.emulated")
COUNT = 64
VALUES = np.random.default_rng(0).normal(10.0, 2.0, COUNT)


def samples(values: np.ndarray, status: np.ndarray | None = None) -> xr.Dataset:
    ends = np.full(values.size, Status.DONE) if status is None else status
    return xr.Dataset({"depth": ("sample", values), "status": ("sample", ends)}, {"sample": np.arange(values.size)})


def made(values: np.ndarray, status: np.ndarray | None = None, **errors: float) -> Scatter:
    return Scatter(samples(values, status), ("a",), values.size, False, 0.9, errors)


def test_intervals_are_wider_by_the_stated_error_on_either_side():
    plain, wide = made(VALUES), made(VALUES, depth=0.5)
    for share in (0.1, 0.5):
        one, other = plain.quantile("depth", share), wide.quantile("depth", share)
        assert (other.value, other.low, other.high) == (one.value, one.low - 0.5, one.high + 0.5)
    one, other = plain.convergence([0.5]), wide.convergence([0.5])
    for name, more in (("value", 0.0), ("low", -0.5), ("high", 0.5)):
        np.testing.assert_allclose(other[name], one[name] + more)
    low, middle, high = (plain.probability("depth", below=place) for place in (9.5, 10.0, 10.5))
    found = wide.probability("depth", below=10.0)
    assert (found.value, found.low, found.high) == (middle.value, low.low, high.high)


def test_a_value_at_a_bound_is_not_below_it():
    assert made(np.arange(64.0)).probability("depth", below=32.0).value == 0.5


def test_negative_samples_that_are_alike_do_not_vary():
    assert not varies(np.full(3, -2.0), 1e-12) and varies(np.array([-2.0, -2.1]), 0.01)


def test_an_end_below_all_samples_is_not_a_life_without_end():
    lives = np.array([1e6, np.inf])
    assert [end_text(end, lives, str) for end in (-np.inf, 1e6, np.inf)] == [
        "too few samples", "1000000.0", "without end"
    ]  # fmt: skip
    assert end_text(np.inf, lives[:1], str) == "too few samples"


def test_correlations_of_which_one_follows_from_the_others_are_refused():
    """Of normal numbers 0.8, 0.8 and 2 0.8^2 - 1: the third is a sum of the others."""
    ranks = 6.0 / np.pi * np.arcsin(0.5 * np.array([0.8, 0.8, 2.0 * 0.8**2 - 1.0]))
    pairs = dict(zip([("a", "b"), ("b", "c"), ("a", "c")], ranks.tolist(), strict=True))
    problems: list[Problem] = []
    assert read_correlation("abc", pairs, problems) is None and "compatible" in str(problems[0])


def test_quantiles_settle_over_the_first_samples():
    found = made(VALUES).convergence([0.5])
    assert found["samples_drawn"].values.tolist() == [8, 16, 32, 64]
    for count in (8, 16, 32, 64):
        expected = estimates.quantile(VALUES[:count], 0.5, 0.9)
        told = found.sel(quantity="depth", share=0.5, samples_drawn=count)
        assert [float(told[name]) for name in ("value", "low", "high")] == [
            expected.value,
            expected.low,
            expected.high,
        ]


def test_samples_for_indices_alone_are_in_no_quantile_and_in_no_count():
    """A paired study of two fields: 2 x 8 independent samples, then 2 x 8 that indices need, most of which failed."""
    values = np.concatenate([VALUES[:16], 1e6 + VALUES[:16]])
    status = np.full(32, Status.DONE)
    status[[1, 20, 21, 22]] = Status.FAILED
    status[[2, 3]] = Status.ENDLESS
    values[[2, 3]] = np.inf
    found = Scatter(samples(values, status), ("a", "b"), 8, True, 0.9)
    assert found.values("depth").tolist() == [VALUES[0], *values[2:16]]
    told = str(found).replace("\n    ", " ")
    assert "16 samples of a, b; 1 failed and do not count; 2 wear no further" in told


def test_indices_of_some_samples_are_those_of_the_first_of_each_set():
    a, b = np.random.default_rng(1).normal(size=(2, 32))
    mixed = np.stack([b, a])
    whole = np.concatenate([a, b, mixed.ravel()])
    found = Scatter(samples(whole), ("one", "two"), 32, True, 0.9)
    for drawn in (None, 8):
        expected = estimates.indices(a[:drawn], b[:drawn], mixed[:, :drawn], 0.9)
        told = found.indices(drawn).sel(quantity="depth")
        np.testing.assert_array_equal(told["first_order"], expected.first_order)
        np.testing.assert_array_equal(told["total"], expected.total)
        for k, end in enumerate(("low", "high")):
            np.testing.assert_array_equal(told[f"first_order_{end}"], expected.first_order_interval[:, k])
            np.testing.assert_array_equal(told[f"total_{end}"], expected.total_interval[:, k])


@pytest.mark.parametrize("wide", [False, True])
def test_errors_of_runs_left_out_are_those_of_the_quantity(wide, monkeypatch):
    """An emulator that told half of every value, or of its logarithm: what is missing is the other half."""
    values = np.geomspace(1.0, 9.0, 24) if wide else np.linspace(8.0, 9.0, 24)
    monkeypatch.setattr(emulated, "emulator_of", lambda inputs, known: Halved(known, wide))
    told, errors, _ = emulated._emulated(samples(values), np.zeros((30, 1)), np.ones(24, dtype=bool))
    assert errors["depth"] == pytest.approx(kept_by(0.5 * values))
    np.testing.assert_array_equal(told["depth"], [*values, *(6 * [np.exp(3.0) if wide else 3.0])])


class Halved:
    """Errors of an emulator whose answers are halves, and 3 for what was not solved."""

    def __init__(self, known: np.ndarray, wide: bool) -> None:
        self.left_out = np.full(known.size, np.log(2.0)) if wide else 0.5 * known

    def at(self, inputs: np.ndarray) -> np.ndarray:
        return np.full(len(inputs), 3.0)
