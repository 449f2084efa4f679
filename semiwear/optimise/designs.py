"""Designs that have been tried: each is solved once at each resolution, several at once in processes."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from semiwear.accuracy.resolution import PARAMETERS
from semiwear.arrays import FloatArray
from semiwear.errors import SceneError
from semiwear.optimise.quantity import Limit, Quantity, measure_of_quantities
from semiwear.optimise.space import Space
from semiwear.scene import Scene
from semiwear.sweep.measure import Measure, Measured
from semiwear.sweep.outcome import solve
from semiwear.sweep.processes import Crew
from semiwear.sweep.scenes import Task

COARSE, OWN, DOUBLED = RESOLUTIONS = ("coarse", "own", "doubled")
"""Resolutions of a design: that of the search, the scene's own, and twice that."""

_PEAKED = "/history/transmission_error_amplitude"
_PEAK_POSITIONS, _MOST_PEAKS = 192, 10_000  # of [numerics]
_GRID = tuple(parameter for parameter in PARAMETERS if parameter.name != "harmonics")


@dataclass(frozen=True)
class Aim:
    """A quantity that is to be small, or large.

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
        """Of a solved scene."""
        return self.quantity.value(measured, low_is_good=self.minimise)


@dataclass(frozen=True)
class Design:
    """A design that was tried.

    Attributes
    ----------
    place : (fields,) array
        In [0, 1].
    resolution : str
        One of `RESOLUTIONS`.
    aims, limited : (n,) arrays
        Values of aims and of limited quantities; NaN where it failed.
    message : str
        Why it failed; empty where it did not.
    """

    place: FloatArray
    resolution: str
    aims: FloatArray
    limited: FloatArray
    message: str = ""

    @property
    def solved(self) -> bool:
        """Whether every number is known; a life without end is infinite."""
        return not (np.isnan(self.aims).any() or np.isnan(self.limited).any())


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
    heard : callable
        Hears of every design that was solved.
    tried : list of Design
        In the order in which they were solved.
    """

    scene: Scene
    space: Space
    aims: tuple[Aim, ...]
    limits: tuple[Limit, ...]
    workers: int
    heard: Callable[[Design], None]
    tried: list[Design] = field(default_factory=list)
    _known: dict[tuple[str, bytes], Design] = field(default_factory=dict)

    def solved(self, places: Sequence[FloatArray], resolution: str) -> list[Design]:
        """Designs at places, those that are not known by now solved first."""
        tasks: dict[str, tuple[Task, tuple[str, bytes], FloatArray]] = {}
        places = [self.space.snapped(place) for place in places]
        for place in places:
            key = self._key(place, resolution)
            if key in self._known:
                continue
            try:
                scene = self.scene_of(place, resolution)
            except SceneError as error:
                self._add(key, self._failed(place, resolution, "; ".join(str(p) for p in error.problems)))
                continue
            name = hashlib.sha256(repr(key).encode()).hexdigest()
            tasks[name] = Task(name, scene, self._measure), key, place
        todo = [task for task, _, _ in tasks.values()]
        with Crew(self.workers if len(todo) > 1 else 0) as crew:
            for outcome in crew.solve(todo):
                _, key, place = tasks[outcome.key]
                if outcome.status.tells:
                    self._add(key, self._read(place, resolution, outcome.measured))
                else:
                    self._add(key, self._failed(place, resolution, outcome.message))
        return [self._known[self._key(place, resolution)] for place in places]

    def of_scene(self) -> Design:
        """The scene as it is, at its own resolution; not one of the designs that were tried."""
        outcome = solve(Task("", self.scene, self._measure))
        place = self.space.start(self.scene)
        if not outcome.status.tells:
            return self._failed(place, OWN, outcome.message)
        return self._read(place, OWN, outcome.measured)

    def scene_of(self, place: FloatArray, resolution: str) -> Scene:
        """The scene of a design.

        Raises
        ------
        SceneError
            The design is no legal scene.
        """
        peaks = _PEAKED in self._measure.variables
        return at_resolution(self.scene.replace(self.space.changes(place)), resolution, peaks=peaks)

    def violation(self, design: Design, bounds: FloatArray) -> float:
        """Greatest excess over the limits, each over the size of its bound; 0 where all are kept."""
        if not design.solved:
            return float("inf")
        worst = 0.0
        for limit, value, bound in zip(self.limits, design.limited, bounds, strict=True):
            worst = max(worst, replace(limit, bound=float(bound)).excess(float(value)) / size_of(limit))
        return worst

    @property
    def bounds(self) -> FloatArray:
        """Bounds of the limits, (limits,)."""
        return np.array([limit.bound for limit in self.limits])

    @property
    def _measure(self) -> Measure:
        quantities = [aim.quantity for aim in self.aims] + [limit.quantity for limit in self.limits]
        return measure_of_quantities(quantities)

    def _key(self, place: FloatArray, resolution: str) -> tuple[str, bytes]:
        return resolution, np.round(place, 12).tobytes()

    def _add(self, key: tuple[str, bytes], design: Design) -> None:
        self._known[key] = design
        self.tried.append(design)
        self.heard(design)

    def _read(self, place: FloatArray, resolution: str, measured: Measured) -> Design:
        aims = np.array([aim.value(measured) for aim in self.aims])
        limited = np.array([limit.quantity.value(measured, low_is_good=limit.at_most) for limit in self.limits])
        found = Design(place.copy(), resolution, aims, limited)
        if found.solved:
            return found
        names = [aim.quantity.text for aim, value in zip(self.aims, aims, strict=True) if np.isnan(value)]
        names += [limit.quantity.text for limit, value in zip(self.limits, limited, strict=True) if np.isnan(value)]
        return replace(found, message=f"its result has no {', '.join(names)}")

    def _failed(self, place: FloatArray, resolution: str, message: str) -> Design:
        nothing = np.full(len(self.aims), np.nan), np.full(len(self.limits), np.nan)
        return Design(place.copy(), resolution, *nothing, message)


def size_of(limit: Limit) -> float:
    """Size that an excess over a limit is compared with."""
    return abs(limit.bound) if limit.bound else 1.0


def at_resolution(scene: Scene, resolution: str, *, peaks: bool = False) -> Scene:
    """The scene on another grid: a coarse one of `numerics.accuracy`, its own, or twice that, as far as it can be.

    With `peaks` other grids than its own find those of the transmission error between roll positions, too: twice as
    many positions may miss the same peak.
    """
    if resolution == OWN:
        return scene
    changes = {}
    if peaks:
        count = scene.numerics.peak_positions or _PEAK_POSITIONS
        changes["numerics.peak_positions"] = count if resolution == COARSE else min(2 * count, _MOST_PEAKS)
    for parameter in _GRID:
        value = int(getattr(scene.numerics, parameter.name))
        new = min(value, parameter.start) if resolution == COARSE else max(min(2 * value, parameter.most), value)
        changes[f"numerics.{parameter.name}"] = new
    return scene.replace(changes)
