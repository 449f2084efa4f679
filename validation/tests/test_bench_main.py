"""The benchmark runs its cases, compares in turns, and says what fails."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.scenes import RIGID, TINY
from validation import bench_main
from validation.bench_cases import CASES, GROWTH, BenchCase, Growth
from validation.bench_worker import answer, scene_of

ALL = [
    *CASES,
    *(BenchCase(kind.name, "", kind.scene, changes) for kind in GROWTH for changes in kind.changes.values()),
]


@pytest.mark.parametrize("case", ALL, ids=lambda case: case.name)
def test_every_case_is_a_valid_scene_on_the_threads_asked_for(case: BenchCase) -> None:
    assert scene_of(case.request(2)).numerics.threads == 2


@pytest.mark.parametrize("action", ["simulate", "loaded_contact", "compliance"])
def test_a_run_tells_time_and_memory(action: Any) -> None:
    told = answer(
        BenchCase("tiny", "", changes=TINY | {"wear.until.control_depths_um": [20.0]}, action=action).request()
    )
    assert told["processor"] > 0.0 and told["wall"] > 0.0
    assert told["peak"] is None or told["peak"] > 50.0
    assert ("contact and wear" in told["stages"]) == (action == "simulate")


class Scripted:
    """A worker whose answers are known."""

    def __init__(self, name: str, seconds: list[float], heard: list[str]) -> None:
        self.name, self.seconds, self.heard = name, iter(seconds), heard

    def run(self, request: dict[str, Any]) -> dict[str, Any]:
        self.heard.append(self.name)
        wall = next(self.seconds)
        if wall < 0.0:
            return {"error": "SceneError: no"}
        return {"wall": wall, "processor": wall, "stages": {"contact": wall / 2.0}, "peak": 100.0 * wall}


def test_two_versions_take_turns_and_the_first_run_does_not_count() -> None:
    heard: list[str] = []
    old, new = Scripted("old", [90.0, 4.0, 8.0, 6.0], heard), Scripted("new", [70.0, 2.0, 2.0, 2.0], heard)
    before, after = bench_main.in_turn([old, new], [{}, {}], 3)
    assert heard == ["old", "new", "new", "old"] * 2
    assert bench_main.ratio_of(before, after) == 3.0
    told = bench_main.summary(before)
    assert (told["wall"], told["least"], told["peak"], told["stages"]) == (6.0, 4.0, 800.0, {"contact": 3.0})


def test_an_error_ends_the_turns_and_is_told() -> None:
    before, after = bench_main.in_turn([Scripted("old", [-1.0], []), Scripted("new", [1.0], [])], [{}, {}], 3)
    assert bench_main.summary(before) == {"error": "SceneError: no"}
    assert bench_main.ratio_of(before, after) is None


def test_copies_side_by_side_are_held_against_one_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    # one runs alone before both of every turn; the slower of both counts, and the first turn does not
    heard: list[str] = []
    first = Scripted("first", [9.0, 9.0, 3.0, 4.0, 2.0, 2.0], heard)
    second = Scripted("second", [9.0, 5.0, 2.0], heard)
    monkeypatch.setattr(bench_main, "workers", lambda trees: contextlib.nullcontext([first, second][: len(trees)]))
    assert bench_main.copies(BenchCase("tiny", ""), 2, 2) == pytest.approx((2 * 3.0 / 5.0 + 2 * 2.0 / 2.0) / 2.0)
    assert sorted(heard[1:3]) == sorted(heard[4:6]) == ["first", "second"]


def test_copies_that_fail_have_no_ratio(monkeypatch: pytest.MonkeyPatch) -> None:
    failing = [Scripted("first", [1.0, 1.0], []), Scripted("second", [-1.0], [])]
    monkeypatch.setattr(bench_main, "workers", lambda trees: contextlib.nullcontext(failing))
    assert bench_main.copies(BenchCase("tiny", ""), 2, 1) is None


def test_exponents_of_growth_are_those_of_the_times(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def known(running: Any, requests: Any, rounds: int) -> Any:
        size = requests[0]["changes"]["size"]
        wall = 0.01 * size**1.5
        return [[{"wall": wall, "processor": wall, "stages": {}, "peak": 3.0 * size}]]

    monkeypatch.setattr(bench_main, "in_turn", known)
    found = bench_main.growth([Growth("size", "size", {float(n): {"size": n} for n in (10, 20, 40)})], 1)
    told = found["size"]
    assert told["exponent"] == pytest.approx(1.5) and told["last exponent"] == pytest.approx(1.5)
    assert told["memory exponent"] == pytest.approx(1.0)
    np.testing.assert_allclose(told["seconds"], 0.01 * np.array([10, 20, 40]) ** 1.5)
    bench_main.draw_growth(found, str(tmp_path / "growth.svg"))
    assert (tmp_path / "growth.svg").stat().st_size > 1000


@pytest.mark.parametrize("words", [["nothing"], ["main", "--repeat", "0"], ["main", "--threads", "0"]])
def test_wrong_arguments_are_told(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        bench_main.main(words)
    assert "error:" in capsys.readouterr().err


@pytest.mark.slow
def test_the_command_writes_its_figures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        bench_main, "CASES", (BenchCase("tiny", "", changes={**TINY, **RIGID}, action="loaded_contact"),)
    )
    # two processes, which starting takes longest, serve both the threads and the copies
    with bench_main.workers([bench_main.ROOT] * 2) as running:
        monkeypatch.setattr(bench_main, "workers", lambda trees: contextlib.nullcontext(running[: len(trees)]))
        bench_main.main(["tiny", "--repeat", "2", "--threads", "1", "2", "--json", str(tmp_path / "figures.json")])
    rows = json.loads((tmp_path / "figures.json").read_text())["warm"]
    assert [(row["case"], row["threads"]) for row in rows] == [("tiny", 1), ("tiny", 2)]
    assert rows[0]["speed-up"] == 1.0 and rows[1]["wall"] > 0.0
    assert rows[0]["copies"] is None and rows[1]["copies"] > 0.0
