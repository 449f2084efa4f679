import warnings
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from semiwear.errors import ResultFileError
from semiwear.report.trends import falls, levels, rises
from semiwear.results import check_tree, open_results, save
from tests.strategies.results import synthetic_tree, trees

series = st.lists(st.floats(-1e6, 1e6).map(lambda value: round(value, 3)), min_size=3, max_size=20).map(np.array)


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(trees())
def test_save_and_open_is_identical(tree):
    with TemporaryDirectory() as folder:
        save(tree, Path(folder) / "worn.nc")
        opened = open_results(Path(folder) / "worn.nc")
    assert opened.identical(tree)
    check_tree(opened)


WHOLE = synthetic_tree(1, profiles=3, faces=3, mesh_positions=1)


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """The bytes of a file that holds it."""
    path = tmp_path_factory.mktemp("whole") / "worn.nc"
    save(WHOLE, path)
    return path.read_bytes()


@pytest.mark.slow
@settings(max_examples=15, deadline=None, phases=[Phase.generate])
@given(place=st.floats(0.0, 1.0, exclude_max=True), change=st.integers(0, 255))
def test_a_changed_or_missing_byte_is_refused_told_or_harmless(saved, place, change):
    """Data are never wrong in silence. No change stands for all bytes from there on missing."""
    with TemporaryDirectory() as folder, warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        path = Path(folder) / "worn.nc"
        content = bytearray(saved)
        at = int(place * len(content))
        if change:
            content[at] ^= change
        else:
            del content[at:]
        path.write_bytes(content)
        try:
            found = open_results(path)
        except ResultFileError:
            return
    same = all(
        np.array_equal(found[group][name].values, array.values, equal_nan=array.dtype.kind == "f")
        for group in WHOLE.children
        for name, array in WHOLE[group].to_dataset().variables.items()
    )
    assert same or any("changed after semiwear saved them" in str(warning.message) for warning in told)


@given(series)
def test_rising_is_falling_upside_down(values):
    assert rises(values).holds == falls(-values).holds
    assert not (rises(values).holds and falls(values).holds)


@given(series)
def test_sorted_series_rise(values):
    ordered = np.sort(values)
    assert rises(ordered).holds == (ordered[-1] > ordered[0])


@given(st.integers(3, 40))
def test_an_even_slope_does_not_level_and_a_saturating_one_does(steps):
    meshes = np.linspace(0.0, 1.0, steps)
    assert not levels(meshes, meshes).holds
    assert levels(np.linspace(0.0, 1.0, 40), 1 - np.exp(-6 * np.linspace(0.0, 1.0, 40))).holds
