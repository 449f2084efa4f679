"""The command `semiwear sweep`: a study file, solved, written and reported."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from semiwear.errors import Collected, MissingExtraError, Problem, SceneError, SemiwearError
from semiwear.simulate import Progress
from semiwear.sweep.files import sweep_target, write_sweep
from semiwear.sweep.outcome import Status
from semiwear.sweep.page import write_sweep_report
from semiwear.sweep.run import Job, read_job, run_job
from semiwear.sweep.store import kept_scenes, open_store
from semiwear.sweep.study_file import Study, read_study
from semiwear.targets import PAGES, file_target, require_apart, target_problems

if TYPE_CHECKING:
    from distributed import Client

_MOST_LISTED = 10
_MOST_DIGITS = 9  # of a number of processes
_ANSWER = 10.0  # s, of a scheduler


def store_of(output: str) -> Path:
    """Folder that keeps the scenes of a study whose result goes to a file."""
    return Path(f"{output}.scenes")


@dataclass(frozen=True)
class Ended:
    """A solved study.

    Attributes
    ----------
    scenes : Dataset
        Every scene.
    dataset : Dataset
        Dataset that is written.
    summary : str
        Text in addition to the numbers of scenes.
    sections : list of (str, str)
        Headings and HTML of the first sections of the page.
    """

    scenes: xr.Dataset
    dataset: xr.Dataset
    summary: str = ""
    sections: list[tuple[str, str]] = field(default_factory=list)


@dataclass(frozen=True)
class Solved:
    """A study that was solved and written, with its summary.

    Attributes
    ----------
    text : str
    scenes : dict of str to int
        Numbers of scenes by status.
    """

    text: str
    scenes: dict[str, int]


@dataclass(frozen=True)
class Prepared:
    """A study that can run.

    Attributes
    ----------
    job : Job
        Scenes that are solved in any case.
    ended : callable
        From a function that solves a sweep to the solved study.
    """

    job: Job
    ended: Callable[[Callable[[Job], xr.Dataset]], Ended]


def prepare_sweep(study: Study, workers: int | str | None) -> Prepared:
    """A study that varies fields.

    Raises
    ------
    SceneError
        With all faults of the fields.
    """
    job = read_job(study.scene, study.vary, **study.options, crew=(workers, None))

    def ended(solve: Callable[[Job], xr.Dataset]) -> Ended:
        found = solve(job)
        return Ended(found, found)

    return Prepared(job, ended)


def run_study(
    study: str, output: str, *, workers: str | None, scheduler: str | None, resume: bool, report: str | None,
    progress: Progress, further: tuple[str, ...] = (), prepare: Callable[[Study, int | str | None], Prepared],
    problems: Sequence[Problem] = (),
) -> Solved:  # fmt: skip
    """Solve a study file, write its dataset and the page if requested; returns the summary.

    `prepare` makes a job of the file, which may also have entries named in `further`; `problems` of
    options are reported with the others.

    Raises
    ------
    SceneError
        With all faults of the file, the scene and the options, before anything runs.
    ResultFileError
        The store beside the output is of another version.
    SemiwearError
        The scheduler cannot be reached, no process started, or an emulator's error is above the limit.
    """
    problems = [*problems, *target_problems("-o", output, sweep_target)]
    problems += target_problems("--report", report, partial(file_target, endings=PAGES))
    ready, store = None, store_of(output)
    count = _workers(workers, scheduler, problems)
    read = read_study(study, further, problems)
    if read is not None:
        try:
            ready = prepare(read, count)
        except SceneError as error:
            unread = any(f"{problem.field}.".startswith("vary.") for problem in problems)
            problems += [
                fault for fault in error.problems if not (unread and fault.field == "vary" and not read.vary)
            ]
        outputs = {"-o": output} | ({"--report": report} if report else {})
        with Collected(problems):
            require_apart({**outputs, "the scenes of -o": store}, read.inputs)
    kept = kept_scenes(store)
    if kept and not resume:
        fix = f"--resume continues from them; or delete {store} to compute everything again"
        problems.append(Problem("--resume", f"left out, and {store} holds {kept} solved scenes", "given", fix))
    if problems or ready is None:
        raise SceneError(problems, study)
    with _client(scheduler) as client:
        opened = open_store(store)
        ended = ready.ended(lambda job: run_job(replace(job, client=client), opened, progress))
    write_sweep(ended.dataset, output)
    lines = [_summary(ended.scenes), *filter(None, [ended.summary]), f"sweep: {output}; its scenes: {store}"]
    if report:
        lines.append(f"report: {write_sweep_report(ended.scenes, report, ended.sections)}")
    return Solved("\n".join(lines), dict(_counts(ended.scenes)))


def _workers(given: str | None, scheduler: str | None, problems: list[Problem]) -> int | str | None:
    if given is None:
        return None
    if scheduler is not None:
        problems.append(Problem("--workers", given, "left out beside --scheduler", "leave one of them out"))
        return None
    return int(given) if given.isdecimal() and len(given) <= _MOST_DIGITS else given


@contextmanager
def _client(address: str | None) -> Iterator[Client | None]:
    if address is None:
        yield None
        return
    try:
        from distributed import Client
    except ImportError as error:
        raise MissingExtraError("dask[distributed]", "sweep", "a sweep on a cluster") from error
    try:
        client = Client(address, timeout=_ANSWER, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise SemiwearError(
            f"--scheduler {address}: no Dask scheduler answers ({error}); start one with `dask scheduler`, and give "
            "the address that it prints, e.g. tcp://10.0.0.1:8786"
        ) from error
    with client:
        yield client


def _counts(found: xr.Dataset) -> list[tuple[str, int]]:
    """Numbers of scenes by status, without zeros."""
    counts = [(kind.name.lower(), int((found["status"].values == kind).sum())) for kind in Status]
    return [(name, count) for name, count in counts if count]


def _summary(found: xr.Dataset) -> str:
    """Numbers of scenes by status, and reasons of failures."""
    status = found["status"]
    names = [kind.name.lower() for kind in Status]
    lines = [f"{status.size} scenes: " + ", ".join(f"{count} {name}" for name, count in _counts(found))]
    if "emulated" in found:
        count = int(found["emulated"].sum())
        lines[0] += f"; of these {status.size - count} were solved and {count} emulated"
    failed = np.argwhere(status.values != Status.DONE)
    for index in failed[:_MOST_LISTED]:
        scene = found.isel(dict(zip(status.dims, map(int, index), strict=True)))
        fields = [array for array in scene.coords.values() if "field" in array.attrs]
        where = ", ".join(f"{array.name} = {array.values}" for array in fields)
        lines.append(f"- {where}: {names[int(scene['status'])]}, {scene['message'].values}")
    if len(failed) > _MOST_LISTED:
        lines.append(f"- and {len(failed) - _MOST_LISTED} more")
    return "\n".join(lines)
