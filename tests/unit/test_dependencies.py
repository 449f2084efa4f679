"""What the project says it needs is what it imports, and can be installed from wheels."""

import re
import tomllib
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest
import yaml
from threadpoolctl import threadpool_info, threadpool_limits

from semiwear.compliance.blas_threads import one_blas_thread

ROOT = Path(__file__).parents[2]
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = SETTINGS["project"]
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


def test_the_recipe_for_conda_says_what_the_project_says():
    recipe = yaml.safe_load((ROOT / "recipe" / "recipe.yaml").read_text(encoding="utf-8"))

    def as_conda(requirement: str) -> str:
        return re.sub(r"([><=!~].*)", r" \1", requirement.lower())

    assert recipe["schema_version"] == 1
    assert recipe["package"]["name"] == PROJECT["name"]
    assert recipe["context"]["version"] == PROJECT["version"]
    assert PROJECT["requires-python"] == f">={recipe['context']['python_min']}"
    needed = recipe["requirements"]
    wanted = ["python >=${{ python_min }}", *map(as_conda, PROJECT["dependencies"])]
    assert sorted(needed["run"]) == sorted(wanted)
    built_with = ["python ${{ python_min }}.*", "pip", *map(as_conda, SETTINGS["build-system"]["requires"])]
    assert sorted(needed["host"]) == sorted(built_with)
    scripts = [f"{name} = {place}" for name, place in PROJECT["scripts"].items()]
    assert recipe["build"]["python"]["entry_points"] == scripts
    imports = [Path(package).name for package in SETTINGS["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]]
    assert recipe["tests"][0]["python"]["imports"] == imports
    about = recipe["about"]
    assert (about["summary"], about["license"]) == (PROJECT["description"], PROJECT["license"])
    assert [about["license_file"]] == PROJECT["license-files"]


def test_the_version_is_the_same_wherever_it_stands():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert str(citation["version"]) == PROJECT["version"]
