"""One scene of a sweep, solved or not: run in this process or in any other."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field, replace
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike
from xarray import DataTree

from semiwear.accuracy import simulate
from semiwear.arrays import BoolArray
from semiwear.compile_ahead import compile_ahead
from semiwear.compliance.blas_threads import one_blas_thread
from semiwear.errors import ConvergenceError, EndlessWearError, SceneError, SemiwearError
from semiwear.life import life_group
from semiwear.plan import plan
from semiwear.plan.choices import kernels_of
from semiwear.simulate import simulate as simulate_as_given
from semiwear.sweep.measure import MESHES, Measured, is_numeric, read_off
from semiwear.sweep.scenes import Task
from semiwear.threads import using_threads

_one_at_a_time = threading.Lock()  # solvers reuse their work space


class Status(IntEnum):
    """End of a scene: solved, or why not. An endless scene is solved: its wear does not reach its end."""

    DONE = 0
    REFUSED = 1
    FAILED = 2
    LOST = 3
    ENDLESS = 4

    @property
    def has_numbers(self) -> bool:
        """Whether the numbers of a scene count; the life or run of an endless one is infinite."""
        return self in (Status.DONE, Status.ENDLESS)


def has_numbers(status: ArrayLike) -> BoolArray:
    """Whether the numbers of scenes with these ends count, of the same shape."""
    return np.isin(status, [kind for kind in Status if kind.has_numbers])


@dataclass(frozen=True)
class Outcome:
    """Numbers of a scene, or the reason why there are none.

    Attributes
    ----------
    key : str
        Key of its task.
    status : Status
    message : str
        Reason of a failure; empty if it is done.
    seconds : float
    measured : Measured
        The finished wear states of a run that stopped midway; empty for other failures. A life without end is
        infinite.
    lasting : bool
        Whether a repetition would give the same: a failure for lack of memory, say, is not kept in a store.
    """

    key: str
    status: Status
    message: str = ""
    seconds: float = 0.0
    measured: Measured = field(default_factory=Measured)
    lasting: bool = True


def solve(task: Task) -> Outcome:
    """Solve a scene; a failure is its outcome, too."""
    begin = time.perf_counter()
    with _one_at_a_time:
        try:
            measured = _life(task) if _is_life(task) else read_off(_simulated(task), task.measure)
        except SceneError as error:
            reasons = "; ".join(str(problem) for problem in error.problems)
            return Outcome(task.key, Status.REFUSED, reasons, time.perf_counter() - begin)
        except ConvergenceError as error:
            if isinstance(error, EndlessWearError) and (error.life or task.measure.last):
                return Outcome(
                    task.key, Status.ENDLESS, str(error), time.perf_counter() - begin, _endless(task, error)
                )
            # a run that stopped midway has no end
            stopped = None if task.measure.last else error.result
            kept = Measured() if stopped is None else read_off(stopped, task.measure)
            return Outcome(task.key, Status.FAILED, str(error), time.perf_counter() - begin, kept)
        except SemiwearError as error:
            return Outcome(task.key, Status.FAILED, str(error), time.perf_counter() - begin)
        except Exception as error:  # of one scene: the others go on
            reason = f"{type(error).__name__}: {error}"
            return Outcome(task.key, Status.FAILED, reason, time.perf_counter() - begin, lasting=False)
    return Outcome(task.key, Status.DONE, "", time.perf_counter() - begin, measured)


def solve_on_one_thread(task: Task) -> Outcome:
    """`solve` where several processes share a machine: on one thread, unless the scene gives their number."""
    numerics = task.scene.numerics
    scene = replace(task.scene, numerics=replace(numerics, threads=numerics.threads or 1))
    return solve(replace(task, scene=scene))


def _endless(task: Task, error: EndlessWearError) -> Measured:
    """The run of a scene whose life has no end, or the known part of a run that has none."""
    measure, scene = task.measure, task.scene
    if error.life:
        # under an accuracy it may be a pilot's run that stopped
        whole = error.result if scene.numerics.accuracy is None else None
        kept = Measured() if whole is None else read_off(whole, measure)
        life = scene.effects.run_life
        ends = ("limit", "end") if life is not None and life.ends_at == "first_failure" else ("limit",)
        units = ("meshes",) if scene.operation.pinion_speed_rpm is None else ("meshes", "hours")
        never = {f"/life/{unit}_to_{end}" for unit in units for end in ends} & set(measure.variables)
    else:
        kept, never = Measured(), {MESHES}
    return replace(kept, variables=kept.variables | {path: np.asarray(np.inf) for path in sorted(never)})


def _is_life(task: Task) -> bool:
    return task.measure.life_alone and task.scene.wear is not None and task.scene.numerics.accuracy is None


def _simulated(task: Task) -> DataTree:
    follows_accuracy = task.scene.numerics.accuracy is not None
    if follows_accuracy and task.compared is None:
        return simulate(task.scene)
    last = task.measure.last and not follows_accuracy
    groups, peaks = task.measure.groups, task.measure.peaks
    return simulate_as_given(task.scene, compared=task.compared, last=last, groups=groups, peaks=peaks)


@one_blas_thread()
def _life(task: Task) -> Measured:
    """The life only, without the wear run of the scene."""
    compile_ahead(kernels_of(task.scene), task.scene.numerics.threads)
    with using_threads(task.scene.numerics.threads):
        physics = replace(plan(task.scene), compared=task.compared)
        arrays = life_group(physics, physics.wear_stepper(physics.loaded_teeth()))
    found = {f"/life/{name}": array for name, array in arrays.items() if is_numeric(array)}
    return Measured({path: found[path] for path in task.measure.variables if path in found})
