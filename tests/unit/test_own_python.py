"""Processes beside this one run the same semiwear, whatever lies in the working folder."""

import subprocess

import semiwear as sw
from semiwear.own_python import command_of, own_environment


def test_sources_in_the_working_folder_are_not_taken(tmp_path):
    """As in a clone from which semiwear was installed: kernels of the sources are of no use to what is installed."""
    (tmp_path / "semiwear").mkdir()
    for name in ("__init__", "__main__"):
        (tmp_path / "semiwear" / f"{name}.py").write_text("raise SystemExit('the wrong semiwear')")
    command = command_of("semiwear", "--version")
    done = subprocess.run(command, cwd=tmp_path, env=own_environment(), capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert sw.__version__ in done.stdout
