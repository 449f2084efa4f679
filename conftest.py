"""Hypothesis profiles, and the scenes and the worn tree that many tests share.

Properties are tried on the same examples at every run. ``HYPOTHESIS_PROFILE=nightly`` draws new ones, and more; their
seed is printed at the end and given again with ``--hypothesis-seed``.
"""

from __future__ import annotations

import hashlib
import os
import random
import shutil
import sys
from collections.abc import Callable, Iterator
from importlib import metadata
from pathlib import Path

import pytest
import xarray as xr
from filelock import FileLock
from hypothesis import settings

import semiwear as sw
from semiwear.compile_ahead import compile_ahead

settings.register_profile("ci", derandomize=True, deadline=None, print_blob=True, max_examples=25)
settings.register_profile("nightly", derandomize=False, deadline=None, print_blob=True, max_examples=500)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))
_DRAWS_ANEW = not settings.default.derandomize


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Choose a seed for new examples before hypothesis looks for one; workers get it with the options."""
    os.environ["MPLBACKEND"] = "agg"
    # workers share the cores: with threads of its own in each, dense algebra waits for itself
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    if "PYTEST_XDIST_WORKER" not in os.environ:
        os.environ["SEMIWEAR_CACHE_DIR"] = str(_kept_teeth(config.rootpath))
        _compile_for_workers(config)
    if _DRAWS_ANEW and config.getoption("--hypothesis-seed") is None:
        config.option.hypothesis_seed = str(random.SystemRandom().randrange(2**32))


def _compile_for_workers(config: pytest.Config) -> None:
    """Compile what several workers would each compile for themselves, on all cores."""
    if (getattr(config.option, "numprocesses", None) or 0) > 1 and not config.option.collectonly:
        for run in ("both", "patch"):
            compile_ahead(run, None)


def _kept_teeth(root: Path) -> Path:
    """Folder of tooth compliance, which all workers and later runs of the very same sources share.

    Any change of semiwear, however far from compliance, makes another folder, and what older sources left goes.
    """
    digest = hashlib.sha256(f"{sys.version} numba {metadata.version('numba')}".encode())
    for path in sorted((root / "semiwear").rglob("*.py")):
        digest.update(os.fsencode(path.relative_to(root)) + b"\0" + path.read_bytes())
    folder = root / ".pytest_cache" / "teeth" / digest.hexdigest()[:40]
    for older in folder.parent.glob("*"):
        if older != folder:
            shutil.rmtree(older, ignore_errors=True)
    return folder


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Say by which seed new examples were drawn."""
    if not _DRAWS_ANEW:
        return
    seed = config.getoption("--hypothesis-seed")
    terminalreporter.write_line(f"new examples were drawn with --hypothesis-seed={seed}")


@pytest.fixture(autouse=True)
def _close_figures() -> Iterator[None]:
    """Close what a test has drawn."""
    yield
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close("all")


@pytest.fixture
def unseen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are made, and not turned into pixels: for tests of the words around them."""
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", lambda *_, **__: None)


@pytest.fixture(scope="session")
def shipped() -> sw.Scene:
    """The scene that ships with semiwear."""
    return sw.load_scene("face_gear_25x160")


@pytest.fixture(scope="session")
def spur() -> sw.Scene:
    """The spur pair that ships with semiwear."""
    return sw.load_scene("spur_fzg_c")


@pytest.fixture(scope="session")
def small(shipped: sw.Scene) -> sw.Scene:
    """The same on coarse grids."""
    return shipped.replace({"numerics.face_slices": 31, "numerics.roll_positions": 12})


@pytest.fixture(scope="session")
def once(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, Callable[[], xr.DataTree]], xr.DataTree]:
    """Results by name that the workers of a machine compute once: the first computes and stores, the others read."""
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent  # each worker has its own in it

    def result(name: str, compute: Callable[[], xr.DataTree]) -> xr.DataTree:
        path = folder / f"{name}.nc"
        with FileLock(f"{path}.lock"):
            if not path.is_file():
                sw.save(compute(), path)
        return sw.open_results(path)

    return result


@pytest.fixture(scope="session")
def worn(shipped: sw.Scene, once: Callable[[str, Callable[[], xr.DataTree]], xr.DataTree]) -> xr.DataTree:
    """The shipped scene, worn."""
    return once("worn", lambda: sw.simulate(shipped))
