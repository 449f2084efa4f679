"""A run to a requested accuracy: coarse runs estimate the errors, one finer run gives the result.

1. A coarse run, and one for each parameter with that parameter alone refined.
2. Richardson's estimate of every contribution; the dominant parameters are refined until the total is allowed.
3. A run with these parameters. Its difference from the coarse run must not exceed the estimated error of the latter;
   where it does, the estimates are raised in proportion.
4. Where the estimates are then too great, a run with half the parameters gives a closer estimate: its difference is
   the error for first order. If that is too great as well, the parameters are refined once more.

Wear steps are adaptive (`semiwear.wear.adaptive`), except in coarse runs, which all have the same steps.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from xarray import DataTree

from semiwear.accuracy.resolution import Contribution, chosen_resolution, contributions_at, parameters_of, together
from semiwear.errors import Collected, ConvergenceError, Problem, SceneError
from semiwear.results.datasets import with_rating_errors
from semiwear.results.kinds import Errors, History, difference, history, worst
from semiwear.scene import Scene
from semiwear.scene.tables import MOST_PEAK_POSITIONS
from semiwear.simulate import ADAPTIVE_STATES, NoProgress, Progress, require_run
from semiwear.simulate import simulate as simulate_as_given

ROUNDS = 3  # final runs at most
_SHARE = 0.85  # of the accuracy for the resolution; errors add as squares, so that half is left for the wear steps
_PEAKS = 8.0  # peak positions times the accuracy: these miss half of it (192: 2.2 %)
_PILOT_STATES = 4  # worn states of a coarse run


def simulate(
    scene: Scene,
    *,
    progress: Progress | None = None,
    fidelity: str | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    resume: bool = False,
) -> DataTree:
    """Simulate the wear of a scene and its effect on contact, root stress and transmission error.

    With `numerics.accuracy` in the scene, the parameters in `[numerics]` that it leaves out are chosen accordingly,
    and `/diagnostics/error_estimate` gives the error of every quantity in `/history` against the converged solution
    of the same fidelity, over the greatest value of its kind (wear depths, pressures, ...).

    Parameters
    ----------
    scene : Scene
        With a table [wear].
    progress : Progress, optional
        Called after every wear step.
    fidelity : str, optional
        Replaces ``numerics.fidelity``.
    checkpoint : path, optional
        Folder in which every finished wear step is saved, so that nothing is lost when the run is killed. It is not
        deleted at the end: delete it when you have saved the result. If an accuracy needs a second and a third run,
        these have folders of their own, `round_checkpoint`.
    resume : bool
        Continue from the wear steps in `checkpoint`, or start anew if there is no such folder. On the same kind of
        processor the result equals that of an undisturbed run, bit for bit, except for `history` and the seconds in
        `/diagnostics`. Without `resume`, the steps of an earlier run are replaced when the first wear step is
        finished.

    Returns
    -------
    DataTree
        Groups `/flank`, `/engagement`, `/mesh_cycle`, `/history`, `/diagnostics` (`semiwear.results.schema`),
        `/ratings` for a scene with tables of failure modes, and `/life` for one with `[effects.run_life]`;
        `wear_step` 0 is unworn. The stored scene has the chosen parameters.

    Raises
    ------
    SceneError
        If the scene has no wear, `fidelity` is unknown, or `resume` is given without `checkpoint`.
    EndlessWearError
        If the flanks wear no further before the depth of a life, or before a control depth; a `ConvergenceError`.
    ConvergenceError
        If a load or wear step cannot be solved, or the accuracy is not reached. The message names the place and what
        to change, and the error's `result` holds the results so far. If the scene gives all parameters itself, the
        error is only estimated: the attribute `accuracy` of the result names the requested and the estimated one.
    ResultFileError
        If the checkpoint belongs to another run, is damaged or in use, or cannot be written.

    Examples
    --------
    >>> import semiwear as sw
    >>> coarse = {"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.wear_steps": 1}
    >>> tree = sw.simulate(sw.load_scene("spur_fzg_c").replace(coarse))
    >>> depth = tree["history"].wear_depth_max.isel(wear_step=-1)
    >>> bool(depth.sel(body="pinion") > depth.sel(body="gear"))
    True
    >>> depth.attrs["units"]
    'um'
    """
    problems: list[Problem] = []
    if fidelity is not None:
        with Collected(problems):
            scene = scene.replace({"numerics.fidelity": fidelity})
    with Collected(problems):
        require_run(scene, checkpoint, resume)
    if problems:
        raise SceneError(problems)
    if scene.numerics.accuracy is None:
        return simulate_as_given(scene, progress=progress, checkpoint=checkpoint, resume=resume)
    if scene.numerics.peak_positions is None:
        count = min(math.ceil(_PEAKS / scene.numerics.accuracy), MOST_PEAK_POSITIONS)
        scene = scene.replace({"numerics.peak_positions": count})
    return _Search(scene, progress or NoProgress()).run(checkpoint, resume)


def round_checkpoint(checkpoint: str | os.PathLike[str], round_: int) -> Path:
    """Folder for the wear steps of a final run: `checkpoint` itself in round 0, then with .2 and .3 appended.

    Coarse runs are not saved; repeated, they give the same results.
    """
    return Path(checkpoint) if round_ == 0 else Path(f"{os.fspath(checkpoint)}.{round_ + 1}")


class _Search:
    """Coarse runs of a scene, and the final runs chosen from them."""

    def __init__(self, scene: Scene, progress: Progress) -> None:
        numerics = scene.numerics
        assert numerics.accuracy is not None
        self.scene, self.asked = scene, numerics.accuracy
        self.parameters = parameters_of(numerics)
        self.open = {p.name for p in self.parameters} & set(numerics.chosen_for_accuracy)
        self.coarse = {p.name: p.start if p.name in self.open else getattr(numerics, p.name) for p in self.parameters}
        self.pilot_scene, self.pilot_states = _pilot(scene)
        self.progress, self.pilots = progress, 0
        self.pilot = self._pilot_history(self.coarse)
        self.parts = tuple(self._contributions())
        self.fixed_steps = self._fixed_step_errors()

    def run(self, checkpoint: str | os.PathLike[str] | None, resume: bool) -> DataTree:
        """Final runs until the accuracy is reached; returns the result of the last one."""
        factors: dict[str, float] = {}
        allowed = _SHARE * self.asked
        for round_ in range(ROUNDS):
            values = chosen_resolution(self.parts, factors, allowed)
            file = None if checkpoint is None else round_checkpoint(checkpoint, round_)
            scene = self._with(self.scene, values)
            tree = simulate_as_given(scene, progress=self.progress, checkpoint=file, resume=resume)
            factors = self._factors(tree, values)
            errors = self._errors(tree, values, factors)
            if worst(errors) <= self.asked or not self.open:
                break
            errors = self._errors(tree, values, factors, self._change_at_half(tree, values))
            if worst(errors) <= self.asked:
                break
            if chosen_resolution(self.parts, factors, allowed) == values:
                break
        _write_estimates(tree, errors, self.asked)
        if worst(errors) > self.asked and self.open:
            name = max(errors, key=lambda key: errors[key])
            raise ConvergenceError(
                f"accuracy {self.asked:g} not reached: {name} is within {errors[name]:.3g} of the greatest value of "
                f"its kind, with {_listed(values)}; ask for less, or leave out numbers of [numerics] "
                "(the error's `result` holds the results so far)",
                tree,
            )
        return tree

    def _contributions(self) -> list[Contribution]:
        parts = []
        for parameter in self.parameters:
            value, open_ = self.coarse[parameter.name], parameter.name in self.open
            # for a given parameter half its value is cheaper to compare with
            halves = not (parameter.refined and open_) and value // 2 >= _least(parameter.name)
            other = value // 2 if halves else 2 * value
            change = difference(self._pilot_history(self.coarse | {parameter.name: other}), self.pilot)
            parts.append(Contribution.between(parameter, value, other, change, open_))
        return parts

    def _fixed_step_errors(self) -> Errors:
        """Error of a given number of wear steps, by comparison with adaptive steps."""
        if "wear_steps" in self.scene.numerics.chosen_for_accuracy:
            return {}
        free = self.pilot_scene.replace({"numerics.wear_steps": None})
        return difference(self.pilot, _coarse_history(self._with(free, self.coarse)))

    def _factors(self, tree: DataTree, values: Mapping[str, int]) -> dict[str, float]:
        """Error of the coarse run over its estimate, at least 1, by quantity."""
        if values == self.coarse:
            return {}
        errors = difference(self.pilot, history(tree, self.pilot_states))
        estimates = together(part.errors for part in self.parts)
        known = {name: size for name, size in estimates.items() if size > 0.0}
        return {name: max(1.0, size / known[name]) for name, size in errors.items() if name in known}

    def _change_at_half(self, tree: DataTree, values: Mapping[str, int]) -> Errors:
        """Change of the result at half of the chosen resolution, which equals the error for first order."""
        self.progress.step(1, 1, "run at half the resolution, for a closer error estimate")
        half = {name: max(value // 2, _least(name)) if name in self.open else value for name, value in values.items()}
        coarser = _coarse_history(self._with(self.pilot_scene, half))
        return difference(coarser, history(tree, self.pilot_states))

    def _errors(
        self,
        tree: DataTree,
        values: Mapping[str, int],
        factors: Mapping[str, float],
        at_half: Errors | None = None,
    ) -> Errors:
        """Estimated errors of a result, from the resolution, chosen and given, and from the wear steps."""
        estimate = tree["diagnostics"].to_dataset()["error_estimate"]
        of_steps = {
            str(name): float(size) for name, size in zip(estimate["quantity"].values, estimate.values, strict=True)
        }
        by_name = contributions_at(self.parts, values)
        chosen, given = (
            {
                name: factors.get(name, 1.0) * size
                for name, size in together(by_name[key] for key in by_name if (key in self.open) is open_).items()
            }
            for open_ in (True, False)
        )
        if at_half is not None:
            chosen = {name: min(size, at_half.get(name, size)) for name, size in chosen.items()}
        return together([of_steps, self.fixed_steps, chosen, given])

    def _pilot_history(self, values: Mapping[str, int]) -> History:
        pilot = _coarse_history(_in_fixed_steps(self._with(self.pilot_scene, values)))
        self.pilots += 1
        self.progress.step(self.pilots, 1 + len(self.parameters), "coarse runs, to choose the resolution")
        return pilot

    def _with(self, scene: Scene, values: Mapping[str, int]) -> Scene:
        return scene.replace({f"numerics.{name}": value for name, value in values.items()})


def _least(name: str) -> int:
    """The least value that a scene may have."""
    return {"roll_positions": 8, "face_slices": 11, "profile_points": 31, "cells_per_half_width": 2}.get(name, 3)


def _pilot(scene: Scene) -> tuple[Scene, list[int] | None]:
    """The scene with a few of its control depths, and their indices among the wear states of the whole run."""
    assert scene.wear is not None
    depths = scene.wear.until.control_depths_um
    changes: dict[str, object] = {"effects.run_life": None}
    if depths is None:
        return scene.replace(changes), None
    kept = np.unique(np.ceil(np.arange(1, _PILOT_STATES + 1) * len(depths) / _PILOT_STATES).astype(int))
    changes["wear.until.control_depths_um"] = [depths[k - 1] for k in kept]
    return scene.replace(changes), [0, *(int(k) for k in kept)]


def _coarse_history(scene: Scene) -> History:
    """Quantities of a coarse run; the amplitude of the transmission error in the first and the last state only."""
    found = history(simulate_as_given(scene, groups=(), peaks=(0, -1)))
    known = np.isin(np.arange(found["meshes"].size), (0, found["meshes"].size - 1))
    return {
        name: np.where(known, values, np.nan) if name == "transmission_error_amplitude" else values
        for name, values in found.items()
    }


def _in_fixed_steps(scene: Scene) -> Scene:
    """The scene with the same few two-stage steps at any resolution, unless it gives its own.

    The error of the steps is then the same in two coarse runs and not part of their difference.
    """
    if "wear_steps" not in scene.numerics.chosen_for_accuracy or scene.numerics.wear_scheme == "explicit":
        return scene
    changes = {"numerics.accuracy": None, "numerics.wear_scheme": "two-stage", "numerics.wear_steps": ADAPTIVE_STATES}
    return scene.replace(changes)


def _write_estimates(tree: DataTree, errors: Errors, asked: float) -> None:
    """Write the error estimates into a result."""
    group = tree["diagnostics"].to_dataset()
    variable = group["error_estimate"]
    estimates = np.array([errors[str(name)] for name in variable["quantity"].values])
    tree["diagnostics"].dataset = group.assign(error_estimate=variable.copy(data=estimates))
    if "ratings" in tree.children:
        with_rating_errors(tree)
    tree.attrs["accuracy"] = f"{asked:g} asked for, {worst(errors):.3g} estimated"


def _listed(values: Mapping[str, int]) -> str:
    return ", ".join(f"{name} = {value}" for name, value in values.items())
