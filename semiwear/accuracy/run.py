"""A run to an accuracy: coarse runs tell what each resolution contributes, one finer run gives the result.

1. A coarse run, and one for each parameter in which that alone is finer.
2. Richardson's estimate of every contribution; the parameters that dominate are refined until the sum is allowed.
3. A run there. Its difference from the coarse run must not exceed what the estimates say of the latter; where it does
   the estimates are raised in proportion.
4. Where they then say too much, a run at half the numbers is asked as well: from so much nearer its difference tells
   the error better, and of first order it is the error. Parameters are refined once more if that is too much, too.

Wear steps look after themselves (`semiwear.wear.adaptive`), but for coarse runs, which all take the same.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from xarray import DataTree

from semiwear.accuracy.resolution import Contribution, chosen_resolution, contributions_at, parameters_of, together
from semiwear.errors import ConvergenceError
from semiwear.results.datasets import with_rating_errors
from semiwear.results.kinds import Errors, History, difference, history, worst
from semiwear.scene import Scene
from semiwear.simulate import ADAPTIVE_STATES, NoProgress, Progress, require_checkpoint
from semiwear.simulate import simulate as simulate_as_given

__all__ = ["ROUNDS", "round_checkpoint", "simulate"]

ROUNDS = 3  # final runs at most
_SHARE = 0.85  # of an asked accuracy for the resolution; as squares it leaves half of it for the wear steps
_PEAKS, _MOST_PEAKS = 8.0, 10_000  # positions that may miss a peak by half of an accuracy, times that (192: 2.2 %)
_PILOT_STATES = 4  # worn states of a coarse run


def simulate(
    scene: Scene,
    *,
    progress: Progress | None = None,
    fidelity: str | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    resume: bool = False,
) -> DataTree:
    """Wear the flank of a scene and follow what it does to contact, root stress and transmission error.

    Where the scene has `numerics.accuracy`, the numbers in its `[numerics]` that it leaves out are chosen for it, and
    `/diagnostics/error_estimate` tells the error of every quantity in `/history`, over the greatest value of its kind
    (wear depths, pressures, ...), against the converged solution of the same fidelity.

    Parameters
    ----------
    scene : Scene
        With a table [wear].
    progress : Progress, optional
        Hears of every finished wear step.
    fidelity : str, optional
        Instead of ``numerics.fidelity``.
    checkpoint : path, optional
        A folder that takes every wear step as soon as it is finished, so that nothing is lost when the run is killed.
        It stays until you delete it: do so when you have saved the result. Where an accuracy takes a second and a
        third run, these have folders of their own, `round_checkpoint`.
    resume : bool
        Go on from the wear steps in `checkpoint`, from the beginning where there is no such folder. On one kind of
        processor the result is that of an undisturbed run, bit for bit, but for `history` and the seconds in
        `/diagnostics`. Without it, an earlier run's steps are replaced when the first wear step is finished.

    Returns
    -------
    DataTree
        Groups `/flank`, `/engagement`, `/mesh_cycle`, `/history`, `/diagnostics` (`semiwear.results.schema`), and
        `/life` where the scene has `[effects.run_life]`; `wear_step` 0 is unworn. Its scene holds the numbers that
        were chosen.

    Raises
    ------
    SceneError
        If the scene has no wear, or `fidelity` is unknown.
    ConvergenceError
        If a load or wear step cannot be solved, or the accuracy is not reached; it names the place and what to
        change, and its `result` holds what was found. Where the scene gives all numbers that play a part, they are
        only judged: the attribute `accuracy` of the result says what was asked for and what is estimated.
    ResultFileError
        If the checkpoint is of another run, damaged, in use, or cannot be written.

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
    if fidelity is not None:
        scene = scene.replace({"numerics.fidelity": fidelity})
    if scene.numerics.accuracy is None or scene.wear is None:
        return simulate_as_given(scene, progress=progress, checkpoint=checkpoint, resume=resume)
    require_checkpoint(checkpoint, resume)  # before the coarse runs
    if scene.numerics.peak_positions is None:
        count = min(math.ceil(_PEAKS / scene.numerics.accuracy), _MOST_PEAKS)
        scene = scene.replace({"numerics.peak_positions": count})
    return _Search(scene, progress or NoProgress()).run(checkpoint, resume)


def round_checkpoint(checkpoint: str | os.PathLike[str], round_: int) -> Path:
    """Folder that keeps the wear steps of a final run: `checkpoint` itself in round 0, then with .2 and .3 behind.

    Coarse runs are not kept: they come out the same when they are repeated.
    """
    return Path(checkpoint) if round_ == 0 else Path(f"{os.fspath(checkpoint)}.{round_ + 1}")


class _Search:
    """Coarse runs of a scene, and what they say."""

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
        """The result."""
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
        _tell(tree, errors, self.asked)
        if worst(errors) > self.asked and self.open:
            name = max(errors, key=lambda key: errors[key])
            raise ConvergenceError(
                f"accuracy {self.asked:g} not reached: {name} is within {errors[name]:.3g} of the greatest value of "
                f"its kind, with {_listed(values)}; ask for less, or leave out numbers of [numerics] "
                "(the error's `result` holds what was found)",
                tree,
            )
        return tree

    def _contributions(self) -> list[Contribution]:
        parts = []
        for parameter in self.parameters:
            value, open_ = self.coarse[parameter.name], parameter.name in self.open
            # of a number that is given, one half as great is cheaper to compare with
            halves = not (parameter.refined and open_) and value // 2 >= _least(parameter.name)
            other = value // 2 if halves else 2 * value
            change = difference(self._pilot_history(self.coarse | {parameter.name: other}), self.pilot)
            parts.append(Contribution.between(parameter, value, other, change, open_))
        return parts

    def _fixed_step_errors(self) -> Errors:
        """Error that a given number of wear steps leaves, against adaptive ones."""
        if "wear_steps" in self.scene.numerics.chosen_for_accuracy:
            return {}
        free = self.pilot_scene.replace({"numerics.wear_steps": None})
        reference = history(simulate_as_given(self._with(free, self.coarse)))
        return difference(self.pilot, reference)

    def _factors(self, tree: DataTree, values: Mapping[str, int]) -> dict[str, float]:
        """By how much the coarse run errs more than its estimates say, quantity by quantity."""
        if values == self.coarse:
            return {}
        found = difference(self.pilot, history(tree, self.pilot_states))
        said = together(part.errors for part in self.parts)
        return {name: max(1.0, size / said[name]) for name, size in found.items() if said.get(name, 0.0) > 0.0}

    def _change_at_half(self, tree: DataTree, values: Mapping[str, int]) -> Errors:
        """Change of a result with half of the numbers that were chosen: of first order, their error."""
        self.progress.step(1, 1, "the same at half the resolution, to know the error better")
        half = {name: max(value // 2, _least(name)) if name in self.open else value for name, value in values.items()}
        coarser = history(simulate_as_given(self._with(self.pilot_scene, half)))
        return difference(coarser, history(tree, self.pilot_states))

    def _errors(
        self,
        tree: DataTree,
        values: Mapping[str, int],
        factors: Mapping[str, float],
        at_half: Errors | None = None,
    ) -> Errors:
        """Estimated errors of a result: of the resolution, chosen and given, and of the wear steps."""
        steps = tree["diagnostics"].to_dataset()["error_estimate"]
        told = {str(name): float(size) for name, size in zip(steps["quantity"].values, steps.values, strict=True)}
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
        return together([told, self.fixed_steps, chosen, given])

    def _pilot_history(self, values: Mapping[str, int]) -> History:
        found = history(simulate_as_given(_in_fixed_steps(self._with(self.pilot_scene, values))))
        self.pilots += 1
        self.progress.step(self.pilots, 1 + len(self.parameters), "coarse runs, to choose the resolution")
        return found

    def _with(self, scene: Scene, values: Mapping[str, int]) -> Scene:
        return scene.replace({f"numerics.{name}": value for name, value in values.items()})


def _least(name: str) -> int:
    """The coarsest value that a scene may have."""
    return {"roll_positions": 8, "face_slices": 11, "profile_points": 31, "cells_per_half_width": 2}.get(name, 3)


def _pilot(scene: Scene) -> tuple[Scene, list[int] | None]:
    """The scene with few of its control depths, and which wear states of the whole run these are."""
    assert scene.wear is not None
    depths = scene.wear.until.control_depths_um
    changes: dict[str, object] = {"effects.run_life": None}
    if depths is None:
        return scene.replace(changes), None
    kept = np.unique(np.ceil(np.arange(1, _PILOT_STATES + 1) * len(depths) / _PILOT_STATES).astype(int))
    changes["wear.until.control_depths_um"] = [depths[k - 1] for k in kept]
    return scene.replace(changes), [0, *(int(k) for k in kept)]


def _in_fixed_steps(scene: Scene) -> Scene:
    """The scene in the same few steps at any resolution, each in two stages, unless it gives its own.

    What steps leave is the same in two coarse runs then, and not in their difference.
    """
    if "wear_steps" not in scene.numerics.chosen_for_accuracy or scene.numerics.wear_scheme == "explicit":
        return scene
    changes = {"numerics.accuracy": None, "numerics.wear_scheme": "two-stage", "numerics.wear_steps": ADAPTIVE_STATES}
    return scene.replace(changes)


def _tell(tree: DataTree, errors: Errors, asked: float) -> None:
    """Write the estimates into a result."""
    group = tree["diagnostics"].to_dataset()
    estimates = group["error_estimate"]
    told = np.array([errors[str(name)] for name in estimates["quantity"].values])
    tree["diagnostics"].dataset = group.assign(error_estimate=estimates.copy(data=told))
    if "ratings" in tree.children:
        with_rating_errors(tree)
    tree.attrs["accuracy"] = f"{asked:g} asked for, {worst(errors):.3g} estimated"


def _listed(values: Mapping[str, int]) -> str:
    return ", ".join(f"{name} = {value}" for name, value in values.items())
