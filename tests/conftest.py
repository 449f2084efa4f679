"""Hypothesis profiles, and the scenes and the worn tree that many tests share."""

from __future__ import annotations

import os

import pytest
import xarray as xr
from hypothesis import settings

import semiwear as sw

settings.register_profile("ci", derandomize=True, deadline=None, print_blob=True, max_examples=25)
settings.register_profile("nightly", max_examples=500, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))


@pytest.fixture(scope="session")
def shipped() -> sw.Scene:
    """The scene that ships with semiwear."""
    return sw.load_scene("face_gear_25x160")


@pytest.fixture(scope="session")
def small(shipped: sw.Scene) -> sw.Scene:
    """The same on coarse grids."""
    return shipped.replace({"numerics.face_slices": 31, "numerics.roll_positions": 12})


@pytest.fixture(scope="session")
def worn(shipped: sw.Scene) -> xr.DataTree:
    """The shipped scene, worn."""
    return sw.simulate(shipped)
