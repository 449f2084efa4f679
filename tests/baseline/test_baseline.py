"""Results are those that were stored, to 1e-9 of each variable's greatest value on the same kind of processor."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from tests.baseline.digest import TOLERANCE, differences, digest
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
