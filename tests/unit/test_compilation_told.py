"""A first run says that it compiles, once, and a second process helps; a run that finds its kernels does neither."""

from __future__ import annotations

import subprocess
import sys

import pytest

from semiwear.commands.compile_ahead import compiling_ahead
from semiwear.commands.progress_bar import ProgressBar
from semiwear.console import notes_on_standard_error
from semiwear.kernel_cache import njit, telling_of_compilation
from tests.scenes import SHIPPED


def kernels():
    """Two kernels that were never compiled; they are kept nowhere."""
    return njit(lambda x: x + 1.0), njit(lambda x: x + 2.0)


def test_compiling_is_told_once():
    told: list[str] = []
    one, other = kernels()
    with telling_of_compilation(lambda: told.append("compiles")):
        assert not told
        assert (one(1.0), other(1.0)) == (2.0, 3.0)
    assert told == ["compiles"]


def test_kernels_that_are_there_are_not_told():
    told: list[str] = []
    one, other = kernels()
    one(1.0)
    with telling_of_compilation(lambda: told.append("compiles")):
        one(1.0)
    other(1.0)  # outside: nobody is told
    assert told == []


def test_a_command_tells_it_on_standard_error(capsys):
    for quiet, lines in ((False, 1), (True, 0)):
        with notes_on_standard_error(quiet), ProgressBar("begins ..."):
            for kernel in kernels():
                kernel(1.0)
        assert capsys.readouterr().err.count("compiling") == lines


class Helper:
    """In place of a process."""

    started: list[Helper]

    def __init__(self, command, **streams) -> None:
        self.command, self.calls = command, []
        Helper.started.append(self)

    def terminate(self) -> None:
        self.calls.append("terminate")

    def wait(self) -> None:
        self.calls.append("wait")


@pytest.fixture
def helpers(monkeypatch) -> list[Helper]:
    Helper.started = []
    monkeypatch.setattr(subprocess, "Popen", Helper)
    return Helper.started


def test_a_second_process_compiles_until_the_run_ends(helpers):
    one, other = kernels()
    with compiling_ahead(SHIPPED.replace({"numerics.threads": 2})):
        assert helpers == []
        one(1.0)
        other(1.0)
        assert [(helper.command[0], helper.calls) for helper in helpers] == [(sys.executable, [])]
    assert helpers[0].calls == ["terminate", "wait"]


@pytest.mark.parametrize("changes", [{"numerics.threads": 1}, {"numerics.fidelity": "patch"}, {"wear": None}])
def test_no_process_without_a_core_or_a_need(helpers, changes):
    with compiling_ahead(SHIPPED.replace({"numerics.threads": 2} | changes)):
        kernels()[0](1.0)
    assert helpers == []


def test_a_process_that_cannot_start_stops_nothing(monkeypatch):
    def fails(*_, **__):
        raise OSError("no more processes")

    monkeypatch.setattr(subprocess, "Popen", fails)
    with compiling_ahead(SHIPPED.replace({"numerics.threads": 2})):
        assert kernels()[0](1.0) == 2.0
