"""Compiled kernels: those of the cache compute the same bits, and where nothing can be written they go elsewhere."""

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
from tests.same_result import different_variables
from tests.scenes import SHIPPED, UNTIL_MESHES

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="permissions of POSIX")


# Lines, and patches whose wear is marched: all that wears a flank, with teeth that need no kernels.
RUNS = {
    "line": {"numerics.roll_positions": 12},
    "marched": {
        "numerics.roll_positions": 24, "numerics.fidelity": "patch", "numerics.wear_mapping": "marched",
    },
}  # fmt: skip


def compute(folder: Path) -> None:
    """The runs, each on as coarse a grid as will do: sums over fewer slices stay in order, whatever is allowed."""
    grid = {"face_slices": 49, "profile_points": 31, "harmonics": 3, "wear_steps": 1, "tooth_compliance": "rigid"}
    changes = UNTIL_MESHES | {"wear.until.meshes": 1e8} | {f"numerics.{name}": value for name, value in grid.items()}
    for name, own in RUNS.items():
        sw.save(sw.simulate(SHIPPED.replace(changes | own)), folder / f"{name}.nc")


@pytest.mark.slow
def test_a_process_that_compiles_and_one_that_finds_kernels_compiled_give_the_same_bits(tmp_path):
    """Kernels with reordered sums that others call are compiled twice, and which copy is taken may differ."""
    kernels, root = tmp_path / "kernels", Path(__file__).parents[2]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(kernels), "PYTHONPATH": str(root)}
    compiled = []
    for process in ("first", "second"):
        (tmp_path / process).mkdir()
        command = [sys.executable, "-m", "tests.unit.test_kernel_cache", str(tmp_path / process)]
        done = subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        compiled.append(sorted(kernels.rglob("*.nbc")))
    assert compiled[0] and compiled[0] == compiled[1]
    for name in RUNS:
        first, second = (sw.open_results(tmp_path / process / f"{name}.nc") for process in ("first", "second"))
        assert different_variables(first, second) == []


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


if __name__ == "__main__":
    compute(Path(sys.argv[1]))
