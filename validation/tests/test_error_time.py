"""Errors over time: what is stored is whole, and the fastest good run is found."""

from __future__ import annotations

import pytest

from validation.error_time import BEFORE, GRIDS, LIMITS, NOW, STEPS, TimedError, fastest_within, measured, stored
from validation.problems import FIGURES, WEAR_PROBLEMS


@pytest.mark.parametrize("problem", [problem.name for problem in WEAR_PROBLEMS])
@pytest.mark.parametrize("version", [NOW, BEFORE])
def test_every_setting_is_stored(problem: str, version: str) -> None:
    points = stored(version, problem)
    assert len({point.setting for point in points}) == len(points) == len(GRIDS) * len(STEPS)
    assert all(set(point.errors) == {figure.name for figure in FIGURES} for point in points)
    assert all(point.seconds > 0.0 for point in points)


def test_the_fastest_run_within_an_error() -> None:
    def timed(seconds: float, *errors: float) -> TimedError:
        return TimedError(NOW, "spur", f"{seconds}", seconds, dict(zip("abc", errors, strict=False)))

    points = [timed(1.0, 0.02, 0.05), timed(3.0, 0.02, 0.01), timed(2.0, 0.03, 0.01), timed(4.0, 0.001, 0.001)]
    found = [fastest_within(points, limit) for limit in (0.03, 0.02, 0.001, 1e-4)]
    assert [None if one is None else one.seconds for one in found] == [2.0, 3.0, 4.0, None]


def test_a_smaller_error_takes_no_less() -> None:
    for problem in WEAR_PROBLEMS:
        took = [fastest_within(stored(NOW, problem.name), limit) for limit in sorted(LIMITS)]
        seconds = [one.seconds for one in took if one is not None]
        assert seconds == sorted(seconds, reverse=True)


def test_errors_are_those_to_the_finest_setting_of_the_same_version() -> None:
    class Answers:
        """A worker whose figures are twice the steps, and those of the finest setting 10."""

        def run(self, request: dict) -> dict:
            changes = request["changes"]
            value = 10.0 if changes["numerics.face_slices"] > 100 else 2.0 * changes["numerics.wear_steps"]
            assert request["history"]
            history = {name: [0.0, -value] for figure in FIGURES for name in figure.variables}
            return {"history": history, "processor": 0.1}

    points = list(measured(WEAR_PROBLEMS[0], {NOW: Answers()}))  # type: ignore[dict-item]
    assert len(points) == len(GRIDS) * len(STEPS)
    for point in points:
        steps = int(point.setting.split()[-2])
        assert point.worst == pytest.approx(abs(2.0 * steps / 10.0 - 1.0))
