"""Compiled kernels: sums stay as they are ordered, and where nothing can be written they go elsewhere."""

import ctypes
import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import semiwear as sw
from semiwear.kernel_cache import njit

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="permissions of POSIX")


def test_what_a_kernel_with_reordered_sums_calls_keeps_the_order_of_its_own():
    """Otherwise which sums are reordered would depend on who compiles a kernel first."""

    @njit(error_model="numpy")
    def total(values):
        found = 0.0
        for i in range(values.shape[0]):
            found += values[i]
        return found

    @njit(error_model="numpy", fastmath={"reassoc", "contract"})
    def twice(values):
        return 2.0 * total(values)

    # one after the other, each of the ones is lost beside the first number
    values = np.array([1e17] + 62 * [1.0] + [-1e17])
    assert twice(values) == 0.0
    assert total(values) == 0.0


def bound_by_permissions() -> None:
    """Take from root what lets it write everywhere; others do not have it."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(24, 1, 0, 0, 0)  # PR_CAPBSET_DROP, CAP_DAC_OVERRIDE


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """An installation, a home and a folder for temporary files; only the last can be written."""
    folder = tmp_path_factory.mktemp("machine")
    source = Path(sw.__file__).parent
    shutil.copytree(source, folder / "site" / "semiwear", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("home", "tmp"):
        (folder / name).mkdir()
    locked = [folder / "home", folder / "site", *(path for path in (folder / "site").rglob("*") if path.is_dir())]
    for path in locked:
        path.chmod(0o555)
    yield folder
    for path in locked:
        path.chmod(0o755)


def semiwear_in(folder: Path, temporary: Path) -> subprocess.CompletedProcess[str]:
    environment = {
        key: value for key, value in os.environ.items() if key not in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")
    }
    environment |= {"PYTHONPATH": str(folder / "site"), "HOME": str(folder / "home"), "TMPDIR": str(temporary)}
    return subprocess.run(
        [sys.executable, "-m", "semiwear", "plan", "face_gear_25x160"], cwd=folder / "site", env=environment,
        preexec_fn=bound_by_permissions, capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.mark.slow
def test_kernels_go_to_a_private_folder_with_one_line_of_warning(installed):
    temporary = installed / "tmp"
    for _ in range(2):  # the second process takes the first one's folder
        done = semiwear_in(installed, temporary)
        assert done.returncode == 0, done.stderr
        (kept,) = temporary.iterdir()
        assert stat.S_IMODE(kept.stat().st_mode) == 0o700
        (line,) = done.stderr.splitlines()
        assert str(kept) in line and "NUMBA_CACHE_DIR" in line


@pytest.mark.slow
def test_a_folder_that_others_can_write_is_not_trusted(installed):
    temporary = installed / "shared"
    temporary.mkdir()
    foreign = temporary / f"semiwear-kernels-{os.getuid()}"
    foreign.mkdir()
    foreign.chmod(0o777)
    assert semiwear_in(installed, temporary).returncode == 0
    assert not list(foreign.iterdir())
    assert len(list(temporary.iterdir())) == 2


def test_an_installation_that_can_be_written_says_nothing(tmp_path):
    code = "import numba, semiwear; assert not numba.config.CACHE_DIR"
    environment = {key: value for key, value in os.environ.items() if key != "NUMBA_CACHE_DIR"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
