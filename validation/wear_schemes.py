"""A whole life by explicit, implicit and two-stage wear steps on one grid: how many solutions an error takes."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

import semiwear as sw
from semiwear.scene import Scene
from semiwear.wear.stepping import WearState, WearStepper
from semiwear.wear.two_stage import TwoStageStepper

SCHEMES = ("explicit", "implicit", "two-stage")
SOLVES_A_STEP = {"explicit": 1, "implicit": 3, "two-stage": 5}
"""Solutions of the loaded contact that a wear step is made of: the elastic contact after it; of an implicit step also
its prediction and itself; of two stages the prediction of the first, each stage and the contact after each."""


@dataclass(frozen=True)
class SchemeRun:
    """A life in so many steps.

    Attributes
    ----------
    scheme : str
    steps : int
    greatest : float [um]
        Greatest wear at the end.
    error : float
        Of it, relative to the converged one.
    flank_error : float
        Norm of the difference over the flank, relative to the converged wear's.
    seconds : float
        Of the processor.
    shrinks : bool
        Whether wear has become less anywhere in any step.
    """

    scheme: str
    steps: int
    greatest: float
    error: float
    flank_error: float
    seconds: float
    shrinks: bool

    @property
    def solves(self) -> int:
        """Solutions of the loaded contact."""
        return self.steps * SOLVES_A_STEP[self.scheme]


@dataclass(frozen=True)
class Life:
    """A number of meshes that a stepper wears; explicit and implicit steps share everything else.

    Attributes
    ----------
    stepper : WearStepper
        Implicit.
    meshes : float
    """

    stepper: WearStepper
    meshes: float

    @cached_property
    def _unworn(self) -> WearState:
        return self.stepper.start()

    def states(self, scheme: str, count: int) -> list[np.ndarray]:
        """Wear [mm] after each of so many steps of even length, the unworn flank first."""
        state, found, stepper = self._unworn, [self._unworn.wear], self._stepper(scheme)
        for _ in range(count):
            state = stepper.step(state, self.meshes / count)
            found.append(state.wear)
        return found

    def _stepper(self, scheme: str) -> WearStepper | TwoStageStepper:
        if scheme == "two-stage":
            return TwoStageStepper(self.stepper)
        return self.stepper if scheme == "implicit" else replace(self.stepper, implicit=False)

    def run(self, scheme: str, count: int, converged: np.ndarray) -> SchemeRun:
        """A life, measured against the converged wear of the flank [mm]."""
        started = time.process_time()
        states = self.states(scheme, count)
        seconds = time.process_time() - started
        shrinks = any(bool((after < before).any()) for before, after in pairwise(states))
        greatest = float(states[-1].max())
        error = abs(greatest / float(converged.max()) - 1.0)
        flank = float(np.linalg.norm(states[-1] - converged) / np.linalg.norm(converged))
        return SchemeRun(scheme, count, 1e3 * greatest, error, flank, seconds, shrinks)


def life_of(scene: Scene) -> Life:
    """The life of a scene that ends at a number of meshes."""
    assert scene.wear is not None and scene.wear.until.meshes is not None
    physics = sw.plan(scene)
    stepper = physics.wear_stepper(physics.loaded_teeth())
    assert isinstance(stepper, WearStepper)
    return Life(stepper, scene.wear.until.meshes)


def solves_for(runs: Sequence[SchemeRun], scheme: str, error: float, of: str = "error") -> int | None:
    """Fewest solutions from which on a scheme keeps an error; None where its longest run does not.

    `of` names the error: ``"error"``, of the greatest wear, or ``"flank_error"``.
    """
    own = sorted((run for run in runs if run.scheme == scheme), key=lambda run: run.steps)
    found = None
    for run in reversed(own):
        if getattr(run, of) > error:
            break
        found = run.solves
    return found
