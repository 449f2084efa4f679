"""Results are those that were stored, to 1e-9 of each variable's greatest value on the same kind of processor."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from tests.baseline.digest import ELSEWHERE, TOLERANCE, differences, digest
from tests.baseline.scenes import RUNS, result
from tests.baseline.stored import read, tolerance


@pytest.mark.slow
@pytest.mark.parametrize("name", RUNS)
def test_results_are_those_that_were_stored(name: str) -> None:
    lines = differences(digest(result(name)), read(name), tolerance(name))
    assert not lines, "\n".join(lines)


def test_a_change_of_any_value_is_seen() -> None:
    values = np.linspace(-1.0, 3.0, 40).reshape(5, 8)
    stored = digest(xr.Dataset({"wear_depth": (("a", "b"), values)}))
    for place in np.ndindex(values.shape):
        for change, seen in ((20.0 * TOLERANCE, True), (0.1 * TOLERANCE, False)):
            other = values.copy()
            other[place] += change * np.abs(values).max()
            assert bool(differences(digest(xr.Dataset({"wear_depth": (("a", "b"), other)})), stored)) == seen
    missing = values.copy()
    missing[0, 0] = np.nan
    assert differences(digest(xr.Dataset({"wear_depth": (("a", "b"), missing)})), stored)
    assert differences(digest(xr.Dataset({"wear": (("a", "b"), values)})), stored)


def test_of_a_conjugate_pairs_error_the_size_counts_and_not_the_digits() -> None:
    def told(error: float) -> dict[str, dict[str, Any]]:
        return digest(xr.Dataset({"transmission_error": ("roll", error * np.array([1.0, -0.3, 0.2]))}))

    assert not differences(told(1e-8), told(2e-9))
    assert differences(told(2e-6), told(2e-9)) and differences(told(2e-9), told(2e-6))
    assert differences(told(1.0 + 20.0 * TOLERANCE), told(1.0))


def test_on_another_processor_a_count_of_iterations_may_be_another_by_one() -> None:
    def told(counts: list[int]) -> dict[str, dict[str, Any]]:
        return digest(xr.Dataset({"iterations": ("wear_step", np.array(counts))}))

    stored = told([12, 8, 9])
    for counts, same, elsewhere in (([12, 8, 9], True, True), ([12, 9, 9], False, True), ([12, 10, 9], False, False)):
        assert bool(differences(told(counts), stored)) != same
        assert bool(differences(told(counts), stored, ELSEWHERE)) != elsewhere
