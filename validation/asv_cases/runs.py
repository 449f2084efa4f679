"""The cases of `bench_cases.py`, timed by asv over the history of the sources."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ["SEMIWEAR_CACHE_DIR"] = "off"
# last: semiwear is the installed version that asv times
sys.path.append(os.fspath(Path(__file__).parents[2]))

from validation.bench_cases import CASES
from validation.bench_worker import ready, scene_of

_CASES = {case.name: case for case in CASES}


class Runs:
    """Warm runs on one thread: seconds, and the greatest memory of the process."""

    params = tuple(_CASES)
    param_names = ("case",)
    timeout = 900
    number = 1
    repeat = (3, 7, 60.0)
    warmup_time = 0.0

    def setup(self, case: str) -> None:
        """Compile, and compute what is kept between runs."""
        request = _CASES[case].request()
        self.run: Callable[[], Any] = ready(request["action"], scene_of(request))
        self.run()
        self.run = ready(request["action"], scene_of(request))

    def time_run(self, case: str) -> None:
        """Wall time."""
        self.run()

    def peakmem_run(self, case: str) -> None:
        """Memory, compilation included."""
        self.run()
