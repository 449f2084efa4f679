"""The contact benchmark runs, says what its JSON promises, and goes on without peers."""

from __future__ import annotations

import importlib
import json
import math
import sys
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

VALIDATION = Path(__file__).parents[1]
MODULES = {"tamaas": "tamaas", "ContactMechanics": "ContactMechanics", "aspher": "aspher"}


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        monkeypatch.setenv(threads, "1")  # the benchmark sets them; this puts them back
    monkeypatch.syspath_prepend(str(VALIDATION))
    yield importlib.import_module("bench_contact")


@pytest.fixture
def no_peers(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in MODULES.values():
        monkeypatch.setitem(sys.modules, module, None)


class Impostor:
    """A peer that is our solver under another name, with something to set up."""

    name = "tamaas"
    variants = ("plain", "hopeless")

    def __init__(self, bench: ModuleType) -> None:
        self.bench = bench

    def can(self, case):
        return True

    def open(self, case, approaches):
        ours = self.bench.Semiwear().open(case)

        def solve(position, start, variant, tolerance):
            answer = ours(position, start, "nested", tolerance)
            if variant == "hopeless":
                return self.bench.Answer(1.1 * answer.pressure, -1, True)
            return answer

        return solve


def test_missing_peers_are_named_and_the_benchmark_goes_on(bench, no_peers, tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.setattr(bench, "cold_calls", lambda: {"kernels compiled": 2.0, "kernels cached": 0.5})
    sweep = bench.RollSweep((10, 20), positions=3)
    monkeypatch.setattr(bench, "RollSweep", lambda points: sweep)
    file = tmp_path / "figures.json"
    bench.main(["--sizes", "16", "--repeats", "1", "--json", str(file)])
    report = json.loads(file.read_text(encoding="utf-8"))

    assert set(report["missing"]) == set(MODULES)
    output = capsys.readouterr()
    for name in MODULES:
        assert f"not installed: {name}" in output.out
        assert f"{name} is not there" in output.err
    assert 'pip install "semiwear[peers]"' in output.out
    assert "kernels compiled 2.00" in output.out

    assert set(report) >= {"machine", "versions", "missing", "cold", "cases", "rows", "target_field_error"}
    assert set(report["versions"]) >= {"numpy", "scipy"}
    assert report["machine"]["cpus"] >= 1
    assert [(case["case"], case["points"], case["positions"]) for case in report["cases"]] == [
        ("elliptic", [16, 16], 1),
        ("sweep", [10, 20], 3),
        ("sweep", [10, 20], 3),
    ]
    for row in report["rows"]:
        assert set(row) == {field.name for field in fields(bench.Row)}
        assert row["code"] == "semiwear"
        assert row["field_error"] <= report["target_field_error"]
        assert row["ms"] > 0.0 and row["new_grid_ms"] > 0.0 and row["convolutions"] > 0.0
        assert row["ratio"] is None and row["met"] is None


def test_peers_are_compared_at_the_same_field_error(bench, monkeypatch) -> None:
    monkeypatch.setattr(bench, "PEERS", (Impostor(bench),))
    monkeypatch.setattr(bench, "REQUIRED", {("elliptic", "tamaas"): {(16, 16): 1e6}})
    kept = []
    sweep = bench.RollSweep((10, 20), positions=2).case()
    report = bench.run([16], [sweep], 2, cold=False, keep=lambda so_far: kept.append(len(so_far["rows"])))
    assert kept == [2, 4], "a long run that is ended loses one case"
    ours, peer, _, swept = report["rows"]
    assert report["cases"][0]["reference_against"]["tamaas"] < 1e-9
    assert peer["tolerance"] == ours["tolerance"] and peer["field_error"] == ours["field_error"]
    assert set(peer["variants_ms"]) == {"plain"}, "a variant that never gets there is left out"
    assert peer["ratio"] == pytest.approx(peer["ms"] / ours["ms"])
    assert peer["met"] is False and swept["met"] is None
    text = bench.table(report)
    assert "tamaas" in text and " NO" in text


def test_a_peer_without_an_answer_is_named(bench, monkeypatch) -> None:
    impostor = Impostor(bench)
    impostor.variants = ("hopeless",)
    monkeypatch.setattr(bench, "PEERS", (impostor,))
    monkeypatch.setattr(bench, "CHECKED", 16 * 16 - 1)
    report = bench.run([16], [], 1, cold=False)
    assert report["cases"][0]["reference_against"] == {}, "peers are not asked on fine grids"
    assert report["cases"][0]["without_answer"] == ["tamaas"]
    assert "tamaas: never within" in bench.table(report)


@pytest.mark.parametrize("first", [0, 3, 6, 9])
@pytest.mark.parametrize("loosest", [0, 4, 9])
def test_cheapest_rung_is_the_loosest_that_does(bench, first, loosest) -> None:
    runs = []

    def error_at(rung: int) -> float:
        runs.append(rung)
        return 1e-6 * bench.STEP ** (loosest - rung - 0.5)

    assert bench.cheapest_rung(error_at, first, 10) == loosest
    assert len(runs) == len(set(runs)), "runs can be long: none twice"
    assert len(runs) == abs(first - loosest) + 1, "no rung is tried that cannot do"


def test_a_pressure_that_is_no_number_is_no_answer(bench) -> None:
    exact = bench.Answer(np.ones((2, 2)), 1, True)
    broken = bench.Answer(np.full((2, 2), np.nan), 1, True)
    assert bench.field_error([exact, broken], [exact, exact]) == math.inf
    assert bench.field_error([exact, exact], [exact, exact]) == 0.0


def test_no_rung_may_do(bench) -> None:
    assert bench.cheapest_rung(lambda rung: math.inf, 2, 5) is None


def test_problems_are_hertz_contacts(bench) -> None:
    problem = bench.HertzProblem(64)
    case = problem.case()
    assert case.hertz.minor_half_axis == pytest.approx(0.35691, abs=1e-5)
    assert case.hertz.major_half_axis == pytest.approx(6.49113, abs=1e-5)
    assert case.hertz.approach == pytest.approx(13.718e-3, abs=1e-6)
    entry = bench.check(case, bench.references(case), [])
    assert entry["peak_error"] == pytest.approx(-3.3e-4, abs=0.1e-4), "the discretisation, the same for all codes"


def test_a_sweep_drifts_smoothly_and_stays_on_its_grid(bench) -> None:
    case = bench.RollSweep((30, 100)).case()
    loads = np.array([problem.load for problem in case.problems])
    assert len(loads) == 40 and loads.max() < 5000.0 and loads.min() == pytest.approx(2000.0)
    assert np.abs(np.diff(loads)).max() < 0.1 * loads.max()
    assert len({problem.cell for problem in case.problems}) == 1
    for answer in bench.references(bench.replace(case, problems=case.problems[::13])):
        edges = np.concatenate([answer.pressure[[0, -1]].ravel(), answer.pressure[:, [0, -1]].ravel()])
        assert answer.converged and not edges.any()


def test_unseen_grids_differ_a_little(bench) -> None:
    case = bench.HertzProblem(16).case()
    cells = {bench.unseen(case, number).problems[0].cell for number in range(4)} | {case.problems[0].cell}
    assert len(cells) == 5
    assert np.ptp([x / y for x, y in cells]) < 1e-8


def test_aspher_takes_square_cells_only(bench) -> None:
    aspher = next(code for code in bench.PEERS if code.name == "aspher")
    assert aspher.can(bench.circular_hertz(64).case())
    assert not aspher.can(bench.HertzProblem(64).case())
    assert not aspher.can(bench.circular_hertz(48).case())
    assert not aspher.can(bench.RollSweep((32, 32), positions=2).case())


@pytest.mark.parametrize("fraction", [0.01, 0.1, 0.5])
def test_rough_surfaces_touch_on_the_share_that_they_are_named_after(bench, fraction):
    case = bench.RoughProblem(128, fraction).case()
    (answer,) = bench.solve_case(bench.Semiwear().open(case), case, "nested", 1e-6)
    assert answer.converged
    assert np.count_nonzero(answer.pressure) / answer.pressure.size == pytest.approx(fraction, rel=0.2)
    assert case.problems[0].gap.std() == pytest.approx(1e-3)
