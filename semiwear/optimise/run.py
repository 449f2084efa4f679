"""The best design within limits: one aim, or the front of two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from semiwear.errors import Collected, Problem, SceneError
from semiwear.optimise.designs import Aim, Design, Designs
from semiwear.optimise.fine import Found, search_finely
from semiwear.optimise.optimum import Optimum, optimum_of
from semiwear.optimise.quantity import Limit, limits_of, quantity_of, unmet_needs
from semiwear.optimise.search import Goal, scan
from semiwear.optimise.space import Space, space_of
from semiwear.scene import Scene
from semiwear.scene.values import is_whole, shown
from semiwear.simulate import Progress, wear_problems
from semiwear.sweep.bar import progress_receiver
from semiwear.sweep.settled import settled
from semiwear.threads import available_threads

_MOST_FIELDS = 12
_COUNT, _COUNT_PER_FIELD = 20, 25  # designs that are tried
_FRONT = 5  # designs between the two ends of a front
_SCAN = 4  # designs of the scan for each field, plus this number


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

    A Sobol' sequence scans the space of designs on a coarse grid; each further design is the optimum of a surrogate
    through the known ones (radial basis functions). The best design is solved at twice the resolution of the scene,
    where aim and limits count, and the search goes on with coarse values corrected accordingly.

    Parameters
    ----------
    scene : Scene
        It needs a table ``[wear]``. If its runs end at control depths, choose meshes or a life as the aim.
    vary : mapping
        From up to 12 dotted keys to a range ``(low, high)``, or to a list of choices. A range of a field that takes
        whole numbers, such as a number of teeth, stands for all of them.
    minimise, maximise : str or sequence of str
        One or two variables of `/history` or `/life`, such as ``"wear_depth_max"``, with body and wear state in
        brackets, such as ``"root_stress_max[pinion, worst]"``. Without brackets: the worse of both bodies at the end
        of the run. Other wear states are ``unworn`` and ``worst``, the worst of all.
    subject_to : mapping, optional
        Limits, such as ``{"transmission_error_amplitude[worst]": "<= 2.5"}``, in the units of results.
    most : int, optional
        Approximate number of designs tried on the coarse grid for each search: the scan takes a power of two and the
        scene itself, and every design solved on a finer grid is followed by a quarter of this number. Default: 20,
        plus 25 for each field.
    workers : int, optional
        Processes of the scan, this one among them; 0: in this process. Default: one per core.
    progress : Progress or bool, optional
        Called after every design; True shows a bar (extra ``progress``).

    Returns
    -------
    Optimum
        The best design, its quantities before and after, their errors, and all designs that were tried. `print` shows
        a summary.

    Raises
    ------
    SceneError
        With all problems of the arguments, before anything runs; also if no design can be solved.

    Notes
    -----
    With ``numerics.accuracy`` the resolution is chosen once, for the scene as given, and kept for the search and the
    best design. A life without end is infinite.

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
    with progress_receiver(progress) as report:
        counter = _Counter(report, planned.designs * (1 if len(planned.aims) == 1 else 2 + _FRONT))
        count = available_threads() if workers is None else workers
        scene = settled(scene)
        designs = Designs(scene, planned.space, planned.aims, planned.limits, count, counter.add)
        return optimum_of(designs, _front(designs, planned.designs))


@dataclass(frozen=True)
class Search:
    """A search whose arguments were checked.

    Attributes
    ----------
    space : Space
    aims : tuple of Aim
    limits : tuple of Limit
    designs : int
        Number of designs tried for one aim.
    """

    space: Space
    aims: tuple[Aim, ...]
    limits: tuple[Limit, ...]
    designs: int


def plan_search(
    scene: Scene | None,
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
        With all problems; without a scene, those that can be found without it.
    """
    problems: list[Problem] = []
    space = None
    with Collected(problems):
        space = space_of(scene, vary)
        if len(space.fields) > _MOST_FIELDS:
            fix = "vary those that `screen` or a sweep calls for"
            problems.append(Problem("vary", len(space.fields), f"at most {_MOST_FIELDS} fields", fix))
    aims = _aims(minimise, maximise, problems)
    limits = limits_of(subject_to, problems)
    judged = [("minimise" if aim.minimise else "maximise", aim.quantity) for aim in aims]
    judged += [(f"subject_to.{limit.quantity.text}", limit.quantity) for limit in limits]
    if scene is not None:
        for field, quantity in judged:
            problems += unmet_needs(field, quantity, scene, vary if isinstance(vary, Mapping) else ())
        problems += wear_problems(scene)
    count = _COUNT + _COUNT_PER_FIELD * (0 if space is None else len(space.fields)) if most is None else most
    if not is_whole(count) or count < 1:
        problems.append(Problem("most", shown(most), "a whole number, 1 or more", "leave it out"))
    if workers is not None and (not is_whole(workers) or workers < 0):
        problems.append(Problem("workers", shown(workers), "a whole number, 0 or more", "leave it out"))
    if problems or scene is None or space is None:
        raise SceneError(problems, "optimise")
    return Search(space, aims, limits, count)


def _aims(minimise: object, maximise: object, problems: list[Problem]) -> tuple[Aim, ...]:
    aims = []
    for field, given in (("minimise", minimise), ("maximise", maximise)):
        if given is None:
            continue
        for text in [given] if isinstance(given, str) or not isinstance(given, Sequence) else given:
            quantity = quantity_of(field, text, problems)
            if quantity is not None:
                aims.append(Aim(quantity, field == "minimise"))
    if len(aims) == 2 and _same(*aims):
        fix = "leave one of them out; a limit of it goes into subject_to"
        problems.append(Problem("maximise", shown(aims[1].quantity.text), "another quantity than the first", fix))
    if not problems and len(aims) not in (1, 2):
        fix = 'such as minimise="wear_depth_max"; limits on other quantities go into subject_to'
        problems.append(Problem("minimise", f"{len(aims)} quantities", "one or two, with maximise", fix))
    return tuple(aims)


def _same(first: Aim, second: Aim) -> bool:
    return replace(first.quantity, text="") == replace(second.quantity, text="")


class _Counter:
    """Counts designs and reports each to the receiver of progress."""

    def __init__(self, progress: Progress, total: int):
        self._progress, self._total, self._done = progress, total, 0

    def add(self, design: Design) -> None:
        self._done += 1
        text = f"{design.resolution} grid" if design.solved else "refused or failed"
        self._progress.step(self._done, max(self._total, self._done), text)


def _front(designs: Designs, most: int) -> list[Found]:
    """Best design for one aim; for two the designs of the front, from the best of the first to that of the second."""
    scanned = scan(designs, min(_SCAN * (len(designs.space.fields) + 1), most))
    if not any(design.solved for design in scanned):
        reasons = list(dict.fromkeys(design.message for design in scanned))[:5]
        raise SceneError.of("vary", f"{len(scanned)} designs", "designs that can be solved", "; ".join(reasons))
    remaining = max(most - len(scanned), 4)
    ends = [search_finely(designs, Goal(aim, designs.bounds), remaining) for aim in range(len(designs.aims))]
    if len(designs.aims) == 1:
        return ends
    first, second = (float(designs.signs[1] * end.doubled.aims[1]) for end in ends)
    between = []
    # no bounds can be set between the ends if one is not solved or is a life without end
    fractions = np.arange(1, _FRONT + 1) / (_FRONT + 1) if np.isfinite([first, second]).all() else ()
    for fraction in fractions:
        goal = Goal(0, designs.bounds, first + fraction * (second - first))
        between.append(search_finely(designs, goal, remaining // 2))
    return _undominated(designs, [ends[0], *between, ends[1]])


def _undominated(designs: Designs, found: list[Found]) -> list[Found]:
    """Designs that keep the limits and are not dominated (no other is better in both aims); all if none keeps them.

    Domination is judged first on the finer grid, then on the grid of the scene, whose values are reported.
    """
    kept = [end for end in found if end.kept] or [end for end in found if end.doubled.solved] or found
    kept = [end for end in kept if end.own.solved] or kept
    chosen = list({end.own.point.tobytes(): end for end in kept}.values())
    for name in ("doubled", "own"):
        values = designs.signs * np.stack([getattr(end, name).aims for end in chosen])
        dominated = [bool(((values <= own).all(axis=1) & (values < own).any(axis=1)).any()) for own in values]
        chosen = [end for end, is_dominated in zip(chosen, dominated, strict=True) if not is_dominated]
    return chosen
