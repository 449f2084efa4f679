"""The best design within limits: one aim, or the front of two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from semiwear.errors import Problem, SceneError
from semiwear.optimise.designs import Aim, Design, Designs
from semiwear.optimise.fine import Found, search_finely
from semiwear.optimise.optimum import Optimum, optimum_of
from semiwear.optimise.quantity import Limit, limits_of, quantity_of, unmet_needs
from semiwear.optimise.search import Goal, scan
from semiwear.optimise.space import Space, space_of
from semiwear.scene import Scene
from semiwear.scene.values import is_whole, shown
from semiwear.simulate import Progress
from semiwear.sweep.bar import hearing
from semiwear.sweep.settled import settled
from semiwear.threads import available_threads

_MOST_FIELDS = 12
_COUNT, _COUNT_A_FIELD = 20, 25  # designs that are tried
_FRONT = 5  # designs between the two ends of a front
_SCAN = 4  # designs for each field, and as many more


def optimise(
    scene: Scene,
    vary: Mapping[str, tuple[float, float] | Sequence[object]],
    *,
    minimise: str | Sequence[str] | None = None,
    maximise: str | Sequence[str] | None = None,
    subject_to: Mapping[str, str | Sequence[str]] | None = None,
    most: int | None = None,
    workers: int | None = None,
    progress: Progress | bool | None = None,
) -> Optimum:
    """Find the design whose worn flanks are best.

    The space of designs is scanned by a Sobol' sequence on a coarse grid; each further design is the best that a
    surrogate of the known ones sees (radial basis functions). What is found is solved at twice the resolution of the
    scene, where aim and limits count, and the search goes on with what that corrects.

    Parameters
    ----------
    scene : Scene
        It needs a table ``[wear]``. Where its runs end at control depths, ask for meshes or a life.
    vary : mapping
        From dotted key to a range ``(low, high)``, or to a list of choices. A range of a field that takes whole
        numbers, such as a number of teeth, stands for all of them.
    minimise, maximise : str or sequence of str
        One or two variables of `/history` or `/life`, such as ``"wear_depth_max"``. In brackets: of which body, and
        when, such as ``"root_stress_max[pinion, worst]"``. Without: of both bodies the worse, at the end of the run
        (``unworn`` and ``worst``, of all wear states, are the others).
    subject_to : mapping, optional
        Limits, such as ``{"transmission_error_amplitude[worst]": "<= 2.5"}``, in the units of results.
    most : int, optional
        About how many designs are tried on the coarse grid for each search: the scan takes a power of two of them and
        the scene itself, and every design that is solved finely is followed by a quarter as many. Default: 20, and 25
        more for each field.
    workers : int, optional
        Processes of the scan; 0: in this process. Default: one a core.
    progress : Progress or bool, optional
        Hears of every design; True shows a bar (extra ``progress``).

    Returns
    -------
    Optimum
        The best design, by how much it is better, its error, and all that were tried. `print` shows a summary.

    Raises
    ------
    SceneError
        With everything that is wrong with the arguments, before anything runs; also where no design can be solved.

    Notes
    -----
    With ``numerics.accuracy`` the scene's numbers are chosen once, for the scene as it is: the search, and the best
    design, have these. A life without end is the greatest of all.

    Examples
    --------
    >>> import semiwear as sw
    >>> coarse = {"numerics.face_slices": 7, "numerics.roll_positions": 8, "numerics.harmonics": 3}
    >>> scene = sw.load_scene("spur_fzg_c").replace({"wear.until.meshes": 1e6} | coarse)
    >>> relief = {"effects.modification.pinion.tip_relief_um": (0.0, 60.0)}
    >>> best = sw.optimise(scene, vary=relief, minimise="transmission_error_amplitude", most=6, workers=0)
    >>> 0.0 < best.scene.effects.modification.pinion.tip_relief_um <= 60.0
    True
    """
    planned = plan_search(scene, vary, minimise, maximise, subject_to, most, workers)
    with hearing(progress) as hears:
        counter = _Counter(hears, planned.designs * (1 if len(planned.aims) == 1 else 2 + _FRONT))
        count = available_threads() if workers is None else workers
        scene = settled(scene)
        designs = Designs(scene, planned.space, planned.aims, planned.limits, count, counter.add)
        return optimum_of(designs, _front(designs, planned.designs))


@dataclass(frozen=True)
class Search:
    """A search that can run.

    Attributes
    ----------
    space : Space
    aims : tuple of Aim
    limits : tuple of Limit
    designs : int
        How many are tried for one aim.
    """

    space: Space
    aims: tuple[Aim, ...]
    limits: tuple[Limit, ...]
    designs: int


def plan_search(
    scene: Scene,
    vary: object,
    minimise: object = None,
    maximise: object = None,
    subject_to: object = None,
    most: int | None = None,
    workers: int | None = None,
) -> Search:
    """A search from arguments of `optimise`.

    Raises
    ------
    SceneError
        With everything that is wrong.
    """
    problems: list[Problem] = []
    space = None
    try:
        space = space_of(scene, vary)
        if len(space.fields) > _MOST_FIELDS:
            fix = "vary those that `screen` or a sweep calls for"
            problems.append(Problem("vary", len(space.fields), f"at most {_MOST_FIELDS} fields", fix))
    except SceneError as error:
        problems += error.problems
    aims = _aims(minimise, maximise, problems)
    limits = limits_of(subject_to, problems)
    asked = [("minimise" if aim.minimise else "maximise", aim.quantity) for aim in aims]
    asked += [(f"subject_to.{limit.quantity.text}", limit.quantity) for limit in limits]
    for field, quantity in asked:
        problems += unmet_needs(field, quantity, scene, vary if isinstance(vary, Mapping) else ())
    if scene.wear is None:
        problems.append(Problem("wear", None, "a table [wear]", "loaded_contact is for scenes without wear"))
    count = _COUNT + _COUNT_A_FIELD * (0 if space is None else len(space.fields)) if most is None else most
    if not is_whole(count) or count < 1:
        problems.append(Problem("most", shown(most), "a whole number, 1 or more", "leave it out"))
    if workers is not None and (not is_whole(workers) or workers < 0):
        problems.append(Problem("workers", shown(workers), "a whole number, 0 or more", "leave it out"))
    if problems or space is None:
        raise SceneError(problems, "optimise")
    return Search(space, aims, limits, count)


def _aims(minimise: object, maximise: object, problems: list[Problem]) -> tuple[Aim, ...]:
    found = []
    for field, given in (("minimise", minimise), ("maximise", maximise)):
        if given is None:
            continue
        for text in [given] if isinstance(given, str) or not isinstance(given, Sequence) else given:
            quantity = quantity_of(field, text, problems)
            if quantity is not None:
                found.append(Aim(quantity, field == "minimise"))
    if len(found) == 2 and _same(*found):
        fix = "leave one of them out; a limit of it goes into subject_to"
        problems.append(Problem("maximise", shown(found[1].quantity.text), "another quantity than the first", fix))
    if not problems and len(found) not in (1, 2):
        fix = 'such as minimise="wear_depth_max"; what else matters goes into subject_to'
        problems.append(Problem("minimise", f"{len(found)} quantities", "one or two, with maximise", fix))
    return tuple(found)


def _same(one: Aim, other: Aim) -> bool:
    return replace(one.quantity, text="") == replace(other.quantity, text="")


class _Counter:
    """Tells progress of every design."""

    def __init__(self, progress: Progress, total: int):
        self._progress, self._total, self._done = progress, total, 0

    def add(self, design: Design) -> None:
        self._done += 1
        text = f"{design.resolution} grid" if design.solved else "refused or failed"
        self._progress.step(self._done, max(self._total, self._done), text)


def _front(designs: Designs, most: int) -> list[Found]:
    """Best designs: one, or those of a front of two aims, from the best of the first to the best of the second."""
    scanned = scan(designs, min(_SCAN * (len(designs.space.fields) + 1), most))
    if not any(design.solved for design in scanned):
        reasons = list(dict.fromkeys(design.message for design in scanned))[:5]
        raise SceneError.of("vary", f"{len(scanned)} designs", "designs that can be solved", "; ".join(reasons))
    left = max(most - len(scanned), 4)
    ends = [Goal(aim, designs.bounds) for aim in range(len(designs.aims))]
    found = [search_finely(designs, goal, left) for goal in ends]
    if len(designs.aims) == 1:
        return found
    sign = 1.0 if designs.aims[1].minimise else -1.0
    first, second = (sign * float(one.doubled.aims[1]) for one in found)
    between = []
    # no bound lies between ends of which one is not solved, or a life without end
    shares = np.arange(1, _FRONT + 1) / (_FRONT + 1) if np.isfinite([first, second]).all() else ()
    for share in shares:
        goal = Goal(0, designs.bounds, first + share * (second - first))
        between.append(search_finely(designs, goal, left // 2))
    return _undominated(designs, [found[0], *between, found[1]])


def _undominated(designs: Designs, found: list[Found]) -> list[Found]:
    """Designs that keep the limits, none of which is better in both aims; all where none keeps them.

    On the finer grid, and of those on the grid of the scene, on which they are told.
    """
    signs = np.array([1.0 if aim.minimise else -1.0 for aim in designs.aims])
    kept = [one for one in found if one.kept] or [one for one in found if one.doubled.solved] or found
    kept = [one for one in kept if one.own.solved] or kept
    chosen = list({one.own.place.tobytes(): one for one in kept}.values())
    for name in ("doubled", "own"):
        values = signs * np.stack([getattr(one, name).aims for one in chosen])
        worse = [bool(((values <= own).all(axis=1) & (values < own).any(axis=1)).any()) for own in values]
        chosen = [one for one, is_worse in zip(chosen, worse, strict=True) if not is_worse]
    return chosen
