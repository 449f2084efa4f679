"""What the project says it needs is what it imports, and can be installed from wheels."""

from __future__ import annotations

import re
import tomllib
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from semiwear.compliance.blas_threads import one_blas_thread

PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
# scikit-sparse has no wheels: it wants the headers of SuiteSparse and a compiler
BUILT = {"scikit-sparse"}


def names(requirements: list[str]) -> set[str]:
    return {re.match(r"[A-Za-z0-9_-]+", one).group() for one in requirements}


def test_threads_of_dense_algebra_are_held_by_a_core_dependency():
    assert "threadpoolctl" in names(PROJECT["dependencies"])
    assert "threads" not in EXTRAS

    def used() -> set[int]:
        np.linalg.solve(np.eye(300), np.ones(300))
        return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}

    with threadpool_limits(2, "blas"):
        before = used()
        with one_blas_thread():
            assert used() == {1}
        assert used() == before == {2}


def test_no_extra_for_users_has_to_be_built():
    for extra in ("all", "plot", "progress", "fem"):
        assert not names(EXTRAS[extra]) & BUILT


@pytest.mark.parametrize("requirement", [*PROJECT["dependencies"], *EXTRAS["plot"], *EXTRAS["progress"]])
def test_lower_bounds_are_stated_and_met(requirement):
    name, bound = re.fullmatch(r"([A-Za-z0-9_-]+)>=([0-9.]+)", requirement).groups()

    def parts(version: str) -> tuple[int, ...]:
        return tuple(int(part) for part in re.findall(r"\d+", version)[:3])

    assert parts(metadata.version(name)) >= parts(bound)
