"""A sweep: scenes that differ in some fields, each solved once, as one labelled dataset."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import xarray as xr

from semiwear.compile_ahead import compile_ahead
from semiwear.errors import Collected, MissingExtraError, Problem, SceneError
from semiwear.plan.choices import kernels_of
from semiwear.scene import Scene
from semiwear.scene.values import is_whole, shown
from semiwear.simulate import Progress, wear_problems
from semiwear.sweep.assemble import assembled
from semiwear.sweep.bar import progress_receiver
from semiwear.sweep.cluster import on_cluster
from semiwear.sweep.measure import Measure, measure_of
from semiwear.sweep.outcome import Outcome
from semiwear.sweep.processes import Crew
from semiwear.sweep.scenes import Member, Task, gather
from semiwear.sweep.store import Store, open_store
from semiwear.sweep.variation import Variation, combine_problems, read_variation
from semiwear.threads import available_threads

if TYPE_CHECKING:
    from distributed import Client
    from pandas import DataFrame

_MOST_WORKERS = 1024


def sweep(
    scene: Scene,
    vary: Mapping[str, Sequence[object]] | DataFrame,
    *,
    measure: str | Sequence[str] | None = None,
    wear_states: str = "all",
    combine: str = "grid",
    workers: int | str | None = None,
    client: Client | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: Progress | bool | None = None,
) -> xr.Dataset:
    """Wear many scenes that differ in some fields.

    Scenes of equal teeth and placement share contact lines and compliance. Scenes that differ only in the wear
    coefficient k share one solution if they end at control depths, or if only a life is measured: wear depends on k
    times the number of meshes, so that meshes, life and hours are inverse to k, and the rest is equal. If runs end
    after a number of meshes, each k is worn by itself.

    Parameters
    ----------
    scene : Scene
        The scene that is varied; it needs a table ``[wear]``.
    vary : mapping or DataFrame
        From dotted key to a list of values, such as ``{"operation.pinion_torque_Nm": [800, 1600]}``: of fields, or of
        tables (``"effects.friction": [None, {}]``; None removes one). A pandas DataFrame has a column for each field
        and a row for each scene.
    measure : str or sequence of str, optional
        Groups and variables of a result that are kept, such as ``["history", "wear_depth"]``. Default: the quantities
        of ``/history``, and ``/life`` if the scene has ``[effects.run_life]``.
    wear_states : str
        ``"all"`` (default): along `wear_step`, unworn first. ``"last"``: at the end of each run.
    combine : str
        For a mapping: ``"grid"`` (default) for all combinations, ``"zip"`` for lists of equal length side by side.
    workers : int or str, optional
        Processes on this machine, each on one thread unless the scene gives `numerics.threads`; 0 or ``"none"``: in
        this process. Default: one per core.
    client : distributed.Client, optional
        Where to run instead: a cluster, one scene at a time on each of its workers (extra ``sweep``).
    store : path, optional
        Folder that keeps every scene as soon as it is solved. A sweep that was stopped, or extended, computes only
        the missing scenes.
    progress : Progress or bool, optional
        Called after every scene; True shows a bar (extra ``progress``).

    Returns
    -------
    Dataset
        Along a dimension for each field, named by the last part of its key, or along `sample`. Variables are named as
        in a result. `status` states whether each scene is done (0), refused (1: its combination is illegal), failed
        (2), lost (3: its process died twice) or endless (4: it wears no further before the depth of its life, which
        is infinite then, or, with ``wear_states="last"``, before its last control depth), `message` why, `seconds`
        how long it took. Values of scenes that failed are NaN, except for the finished wear states of a run that
        stopped midway, of which `last_wear_step` is the last (with ``wear_states="last"`` there are none). All but
        `seconds` are bitwise equal for any order and place of the solutions, on one kind of processor.

    Raises
    ------
    SceneError
        With all faults of the arguments, before anything runs; also if every scene is illegal.
    ResultFileError
        The store was written by another version, is something else, or cannot be written.
    MissingExtraError
        `progress` is True without tqdm, or `client` given without Dask.

    Examples
    --------
    >>> import semiwear as sw
    >>> coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.wear_steps": 1}
    >>> scene = sw.load_scene("spur_fzg_c").replace(coarse)
    >>> found = sw.sweep(scene, {"operation.pinion_torque_Nm": [200.0, 300.0]}, workers=0)
    >>> found.root_stress_max.dims
    ('pinion_torque_Nm', 'wear_step', 'body')
    >>> found.status.values.tolist()
    [0, 0]
    """
    job = read_job(scene, vary, measure=measure, wear_states=wear_states, combine=combine, crew=(workers, client))
    with progress_receiver(progress) as report:
        return run_job(job, open_store(store), report)


@dataclass(frozen=True)
class Job:
    """A sweep with valid arguments.

    Attributes
    ----------
    scene : Scene
    variation : Variation
    measure : Measure
    members : list of Member
        The scenes.
    tasks : dict of str to Task
        The solutions that they need.
    workers : int
        Processes; 0 for this one.
    client : Client or None
    """

    scene: Scene
    variation: Variation
    measure: Measure
    members: list[Member]
    tasks: dict[str, Task]
    workers: int
    client: Client | None = None


def read_job(
    scene: Scene | None,
    vary: Mapping[str, Sequence[object]] | DataFrame,
    *,
    measure: str | Sequence[str] | None = None,
    wear_states: str = "all",
    combine: str = "grid",
    crew: tuple[int | str | None, Client | None] = (None, None),
) -> Job:
    """The job of arguments of `sweep`; `crew` holds `workers` and `client`.

    Raises
    ------
    SceneError
        With all faults; without a scene, those that can be found without it.
    """
    problems = combine_problems(combine)
    variation = measured = None
    with Collected(problems):
        variation = read_variation(scene, vary, combine)
    if scene is not None and (variation is None or all(axis.key != "wear" for axis in variation.axes)):
        problems += wear_problems(scene)
    with Collected(problems):
        measured = measure_of(measure, wear_states)
    count, wrong = workers_of(*crew)
    problems += wrong
    if problems or scene is None or variation is None or measured is None:
        raise SceneError(problems, "sweep")
    members, tasks = gather(scene, variation, measured)
    if measured.life_alone and not any(task.scene.effects.run_life for task in tasks.values()):
        allowed = "quantities that a result of these scenes has"
        raise SceneError.of("measure", "only a life", allowed, "give the scene [effects.run_life], which ends it")
    return Job(scene, variation, measured, members, tasks, count, crew[1])


def crew_of(crew: int | str | Client | None) -> tuple[int | str | None, Client | None]:
    """`workers` and `client` from one argument that is either."""
    return (crew, None) if crew is None or isinstance(crew, int | str) else (None, crew)


def workers_of(workers: object, client: object) -> tuple[int, list[Problem]]:
    """Number of processes, and problems with it."""
    allowed = f'a whole number, 0 (or "none": in this process) to {_MOST_WORKERS}'
    if workers is None:
        return available_threads(), []
    if client is not None:
        return 0, [Problem("workers", shown(workers), "left out beside client=", "leave one of them out")]
    if workers == "none":
        return 0, []
    if not is_whole(workers) or not 0 <= workers <= _MOST_WORKERS:
        return 0, [Problem("workers", shown(workers), allowed, "leave it out for one process per core")]
    return workers, []


def run_job(job: Job, store: Store, progress: Progress) -> xr.Dataset:
    """Solve the tasks that the store does not hold, and assemble the dataset."""
    solve_job(job, store, progress)
    return assembled(job.scene, job.variation, job.measure, job.members, store)


def solve_job(job: Job, store: Store, progress: Progress) -> None:
    """Solve the tasks that the store does not hold, and add their outcomes to it."""
    scenes: dict[str, int] = {}
    for member in job.members:
        scenes[member.key] = scenes.get(member.key, 0) + 1
    done = failed = scenes.get("", 0)
    missing = []
    for key, task in job.tasks.items():
        kept = store.get(key)
        if kept is None:
            missing.append(task)
        else:
            done += scenes[key]
            failed += scenes[key] * (not kept.status.has_numbers)
    total = len(job.members)
    progress.step(done, total, _failures_text(failed))
    for outcome in _outcomes(job, missing):
        store.put(outcome)
        done += scenes[outcome.key]
        failed += scenes[outcome.key] * (not outcome.status.has_numbers)
        progress.step(done, total, _failures_text(failed))


def _failures_text(failed: int) -> str:
    return f"{failed} failed" if failed else ""


def _outcomes(job: Job, tasks: Sequence[Task]) -> Iterator[Outcome]:
    if not tasks:
        return
    if job.client is None:
        with Crew(min(job.workers, len(tasks))) as crew:
            if job.workers > 1:  # otherwise each of them would compile everything
                crew.call()
                for run in {kernels_of(task.scene) for task in tasks}:
                    compile_ahead(run, job.workers)
            yield from crew.solve(tasks)
        return
    try:
        yield from on_cluster(tasks, job.client)
    except ImportError as error:
        raise MissingExtraError("dask[distributed]", "sweep", "a sweep on a cluster") from error
