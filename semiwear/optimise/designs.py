"""Designs that were tried, each solved once at each resolution, several at once in processes."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from semiwear.accuracy.resolution import PARAMETERS
from semiwear.arrays import FloatArray
from semiwear.errors import SceneError
from semiwear.optimise.quantity import WITH_PEAKS, Limit, Quantity, measure_of_quantities
from semiwear.optimise.space import Space
from semiwear.scene import Scene
from semiwear.scene.tables import MOST_PEAK_POSITIONS
from semiwear.sweep.measure import Measure, Measured
from semiwear.sweep.outcome import Outcome, solve
from semiwear.sweep.processes import Crew
from semiwear.sweep.scenes import Task

COARSE, OWN, DOUBLED = RESOLUTIONS = ("coarse", "own", "doubled")
"""Resolutions of a design: that of the search, the scene's own, and twice that."""

_PEAK_POSITIONS = 192  # of [numerics]
_GRID = tuple(parameter for parameter in PARAMETERS if parameter.name != "harmonics")


@dataclass(frozen=True)
class Aim:
    """A quantity that is minimised or maximised.

    Attributes
    ----------
    quantity : Quantity
    minimise : bool
    """

    quantity: Quantity
    minimise: bool = True

    def __str__(self) -> str:
        return f"{'least' if self.minimise else 'greatest'} {self.quantity.text}"

    def value(self, measured: Measured) -> float:
        """Value of the quantity in a solved scene."""
        return self.quantity.value(measured, low_is_good=self.minimise)


@dataclass(frozen=True)
class Design:
    """A design that was tried.

    Attributes
    ----------
    point : (fields,) array
        Its coordinates in the space, each in [0, 1].
    resolution : str
        One of `RESOLUTIONS`.
    aims, limited : (n,) arrays
        Values of aims and of limited quantities; NaN where it failed.
    message : str
        Why it failed; empty where it did not.
    """

    point: FloatArray
    resolution: str
    aims: FloatArray
    limited: FloatArray
    message: str = ""

    @property
    def values(self) -> FloatArray:
        """Values of aims, then of limited quantities."""
        return np.concatenate([self.aims, self.limited])

    @property
    def solved(self) -> bool:
        """Whether all its values are known; a life without end is infinite."""
        return not np.isnan(self.values).any()


@dataclass
class Designs:
    """All designs of a search.

    Attributes
    ----------
    scene : Scene
    space : Space
    aims : tuple of Aim
    limits : tuple of Limit
    workers : int
        Processes; 0: in this one.
    on_solved : callable
        Called with every design that was solved.
    tried : list of Design
        In the order in which they were solved.
    """

    scene: Scene
    space: Space
    aims: tuple[Aim, ...]
    limits: tuple[Limit, ...]
    workers: int
    on_solved: Callable[[Design], None]
    tried: list[Design] = field(default_factory=list)
    _known: dict[tuple[str, bytes], Design] = field(default_factory=dict)

    def solved(self, points: Sequence[FloatArray], resolution: str) -> list[Design]:
        """Designs at points; those that are not known yet are solved."""
        tasks: dict[str, tuple[Task, tuple[str, bytes], FloatArray]] = {}
        points = [self.space.snapped(point) for point in points]
        for point in points:
            key = self._key(point, resolution)
            if key in self._known:
                continue
            try:
                scene = self.scene_of(point, resolution)
            except SceneError as error:
                self._add(key, self._failed(point, resolution, "; ".join(str(p) for p in error.problems)))
                continue
            name = hashlib.sha256(repr(key).encode()).hexdigest()
            tasks[name] = Task(name, scene, self._measure), key, point
        todo = [task for task, _, _ in tasks.values()]
        with Crew(self.workers if len(todo) > 1 else 0, helped=True) as crew:
            for outcome in crew.solve(todo):
                _, key, point = tasks[outcome.key]
                self._add(key, self._read(point, resolution, outcome))
        return [self._known[self._key(point, resolution)] for point in points]

    def of_scene(self) -> Design:
        """Design of the scene as given, at its own resolution; it is not added to the designs that were tried."""
        return self._read(self.space.start(self.scene), OWN, solve(Task("", self.scene, self._measure)))

    def scene_of(self, point: FloatArray, resolution: str) -> Scene:
        """Scene of a design.

        Raises
        ------
        SceneError
            The scene is not valid.
        """
        peaks = WITH_PEAKS in self._measure.variables
        return at_resolution(self.scene.replace(self.space.changes(point)), resolution, peaks=peaks)

    def violation(self, design: Design, bounds: FloatArray) -> float:
        """Greatest excess over a limit, relative to the size of its bound; 0 if all limits are kept."""
        return float(self.excesses(design.limited, bounds).max(initial=0.0)) if design.solved else float("inf")

    def excesses(self, limited: FloatArray, bounds: FloatArray) -> FloatArray:
        """How far limited quantities (..., limits) lie beyond bounds, relative to the sizes of the limits."""
        senses = np.array([1.0 if limit.at_most else -1.0 for limit in self.limits])
        return np.asarray(senses * (limited - bounds) / np.array([size_of(limit) for limit in self.limits]))

    @property
    def bounds(self) -> FloatArray:
        """Bounds of the limits, (limits,)."""
        return np.array([limit.bound for limit in self.limits])

    @property
    def signs(self) -> FloatArray:
        """1 for an aim that is minimised, -1 for one that is maximised, (aims,)."""
        return np.array([1.0 if aim.minimise else -1.0 for aim in self.aims])

    @property
    def quantities(self) -> list[Quantity]:
        """Quantities of the aims, then limited ones."""
        return [*(aim.quantity for aim in self.aims), *(limit.quantity for limit in self.limits)]

    @property
    def _measure(self) -> Measure:
        return measure_of_quantities(self.quantities)

    def _key(self, point: FloatArray, resolution: str) -> tuple[str, bytes]:
        return resolution, np.round(point, 12).tobytes()

    def _add(self, key: tuple[str, bytes], design: Design) -> None:
        self._known[key] = design
        self.tried.append(design)
        self.on_solved(design)

    def _read(self, point: FloatArray, resolution: str, outcome: Outcome) -> Design:
        if not outcome.status.has_numbers:
            return self._failed(point, resolution, outcome.message)
        measured = outcome.measured
        aims = np.array([aim.value(measured) for aim in self.aims])
        limited = np.array([limit.quantity.value(measured, low_is_good=limit.at_most) for limit in self.limits])
        design = Design(point.copy(), resolution, aims, limited)
        if design.solved:
            return design
        judged = zip(self.quantities, design.values, strict=True)
        names = [quantity.text for quantity, value in judged if np.isnan(value)]
        return replace(design, message=f"its result has no {', '.join(names)}")

    def _failed(self, point: FloatArray, resolution: str, message: str) -> Design:
        unknown = np.full(len(self.aims), np.nan), np.full(len(self.limits), np.nan)
        return Design(point.copy(), resolution, *unknown, message)


def size_of(limit: Limit) -> float:
    """Size by which an excess over a limit is divided: that of its bound, 1 for a bound of 0."""
    return abs(limit.bound) if limit.bound else 1.0


def at_resolution(scene: Scene, resolution: str, *, peaks: bool = False) -> Scene:
    """Scene on the coarse grid of `numerics.accuracy`, its own, or one twice as fine, as far as that is allowed.

    With `peaks`, grids other than its own include peaks of the transmission error between roll positions, since twice
    as many positions may miss the same peak.
    """
    if resolution == OWN:
        return scene
    changes = {}
    if peaks:
        count = scene.numerics.peak_positions or _PEAK_POSITIONS
        changes["numerics.peak_positions"] = count if resolution == COARSE else min(2 * count, MOST_PEAK_POSITIONS)
    for parameter in _GRID:
        value = int(getattr(scene.numerics, parameter.name))
        new = min(value, parameter.start) if resolution == COARSE else max(min(2 * value, parameter.most), value)
        changes[f"numerics.{parameter.name}"] = new
    return scene.replace(changes)
