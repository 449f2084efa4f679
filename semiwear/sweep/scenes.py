"""The scenes of a sweep: each combination checked, and which of them share a solution or their geometry."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import lru_cache

from semiwear.errors import Problem, SceneError
from semiwear.plan import Compared
from semiwear.scene import BodyCoefficients, Scene
from semiwear.scene.external import file_digests
from semiwear.scene.rating_tables import RatingTable
from semiwear.sweep.measure import Measure
from semiwear.sweep.variation import Variation
from semiwear.untyped import Table

__all__ = ["Member", "Task", "gather", "geometry_of", "scenes_of", "shared_by", "shared_solution"]

_COEFFICIENT = "wear.coefficient_mm2_per_N"
_ENDS = frozenset({"/life/meshes_to_end", "/life/hours_to_end", "/life/ended_by"})
_MOST_SHOWN = 20


@dataclass(frozen=True)
class Task:
    """A scene to be solved.

    Attributes
    ----------
    key : str
        Digest of everything that the answer depends on but the code.
    scene : Scene
    measure : Measure
    compared : Compared, optional
        Where its run is to be compared with others of nearly the same scene.
    """

    key: str
    scene: Scene
    measure: Measure
    compared: Compared | None = None


@dataclass(frozen=True)
class Member:
    """One scene of a sweep: where its numbers come from, or why it has none.

    Attributes
    ----------
    key : str
        Of the task that solves it; empty where the scene is refused.
    stretch : float
        Number of meshes over that of the task.
    refused : str
        What is wrong with the combination.
    """

    key: str
    stretch: float = 1.0
    refused: str = ""


def scenes_of(scene: Scene, variation: Variation) -> list[Scene | SceneError]:
    """Each scene of a sweep, or what is wrong with it.

    Raises
    ------
    SceneError
        Where every combination is illegal.
    """
    base = replace(scene, _check=None if scene._check is None else _remembered(scene._check, scene))
    found: list[Scene | SceneError] = []
    for changes in variation.changes():
        try:
            one = replace(base.replace(changes), _check=scene._check)
            if one.wear is None:
                raise SceneError.of("wear", None, "a table [wear]", "loaded_contact is for scenes without wear")
            found.append(one)
        except SceneError as error:
            found.append(error)
    errors = [one for one in found if isinstance(one, SceneError)]
    if len(errors) == len(found):
        problems = list({str(problem): problem for error in errors for problem in error.problems}.values())
        raise SceneError(problems[:_MOST_SHOWN], "sweep, every scene")
    return found


def _remembered(check: Callable[[Scene], Iterable[Problem]], base: Scene) -> Callable[[Scene], list[Problem]]:
    """Limits of the teeth, found once for scenes that differ only in what these limits do not look at.

    That is how the pair is loaded, of what it is made, how fast and how long it wears, and which effects
    act, unless one names a file.
    """

    @lru_cache(maxsize=256)
    def found(geometry: Scene) -> tuple[Problem, ...]:
        return tuple(check(geometry))

    def problems(scene: Scene) -> list[Problem]:
        wear = scene.wear
        if wear is not None and base.wear is not None:
            wear = replace(wear, coefficient_mm2_per_N=base.wear.coefficient_mm2_per_N, until=base.wear.until)
        # of effects limits look at the files with deviations alone
        effects = scene.effects if _names_files(scene) or _names_files(base) else base.effects
        operation = replace(base.operation, loaded_flank=scene.operation.loaded_flank)
        return list(
            found(
                replace(
                    scene, title=base.title, operation=operation, material=base.material, wear=wear,
                    effects=effects, _check=None,
                )
            )
        )  # fmt: skip

    return problems


def _names_files(scene: Scene) -> bool:
    return any(getattr(table, "file", None) is not None for _, table in scene.effects.present())


def gather(scene: Scene, variation: Variation, measure: Measure) -> tuple[list[Member], dict[str, Task]]:
    """Scenes of a sweep, and what is to be solved for them: once what several share.

    Scenes that differ in the wear coefficient alone share a solution where that is exact (`shared_solution`).

    Raises
    ------
    SceneError
        Where every combination is illegal.
    """
    members: list[Member] = []
    tasks: dict[str, Task] = {}
    varied = {axis.key for axis in variation.axes}
    for one in scenes_of(scene, variation):
        if isinstance(one, SceneError):
            members.append(Member("", refused="; ".join(str(problem) for problem in one.problems)))
            continue
        solved, stretch = shared_solution(one, scene, measure) if varied & {_COEFFICIENT, "wear"} else (one, 1.0)
        plain = replace(
            solved, title="", reference=None, numerics=replace(solved.numerics, threads=None), _check=None
        )
        key = _digest(plain, measure)
        threads = solved.numerics.threads
        tasks.setdefault(key, Task(key, replace(plain, numerics=replace(plain.numerics, threads=threads)), measure))
        members.append(Member(key, stretch))
    return members, tasks


def shared_solution(scene: Scene, base: Scene, measure: Measure) -> tuple[Scene, float]:
    """The scene with the wear coefficient of another one, and by what its meshes are longer than there.

    Wear knows the coefficient k only times the number N of meshes: every law of the coefficient is a factor on k N.
    A run that ends at given depths, and a life, therefore find the same k N for every k, and the same contact. A run
    of a given number of meshes does not; nor do two bodies that wear with another ratio of their coefficients. Such a
    scene comes back as it is; so does one of which damage of failure modes is measured: Miner's sum counts meshes N,
    not k N.
    """
    ours, theirs = scene.wear, base.wear
    if ours is None or theirs is None or ours.coefficient_mm2_per_N == theirs.coefficient_mm2_per_N:
        return scene, 1.0
    if _measures_damage(scene, measure):
        return scene, 1.0
    if ours.until.control_depths_um is None and not measure.life_alone:
        return scene, 1.0
    try:
        pairs = [(theirs.coefficient(body), ours.coefficient(body)) for body in ours.worn_bodies]
    except SceneError:
        return scene, 1.0
    stretch = pairs[0][0] / pairs[0][1]
    if any(their / our != stretch for their, our in pairs[1:]):
        return scene, 1.0
    ours = replace(ours, data=None, coefficient_mm2_per_N=_of_worn(pairs, ours.worn_bodies))
    return replace(scene, wear=ours), stretch


def _measures_damage(scene: Scene, measure: Measure) -> bool:
    """Whether what is measured knows of failure modes, which the scene rates."""
    if not any(isinstance(table, RatingTable) for table in vars(scene.effects).values()):
        return False
    life = scene.effects.run_life
    ends = _ENDS if life is not None and life.ends_at == "first_failure" else frozenset[str]()
    return any(path.startswith("/ratings/") or path in ends for path in measure.variables)


def _of_worn(pairs: list[tuple[float, float]], bodies: tuple[str, ...]) -> float | BodyCoefficients:
    if len({their for their, _ in pairs}) == 1:
        return pairs[0][0]
    return BodyCoefficients(**{body: their for body, (their, _) in zip(bodies, pairs, strict=True)})


def _digest(scene: Scene, measure: Measure) -> str:
    told = [scene.to_toml(), sorted(file_digests(scene.to_dict()).items()), measure.variables, measure.last]
    return hashlib.sha256(json.dumps(told).encode()).hexdigest()[:32]


def shared_by(task: Task) -> tuple[str, str]:
    """`geometry_of` a task's scene; of runs whose prisms are read on one course, digests of that."""
    course = None if task.compared is None else task.compared.course
    if course is None:
        return geometry_of(task.scene)
    ends = hashlib.sha256(repr((course.at, course.beside)).encode()).hexdigest()
    return ends, ends


def geometry_of(scene: Scene) -> tuple[str, str]:
    """Digests of what decides a scene's teeth, and its contact lines: scenes with equal ones share those."""
    data: Table = scene.to_dict()
    teeth = {"gear_pair": data["gear_pair"], "material": data.get("material"), "loaded": data["operation"]}
    teeth["loaded"] = data["operation"].get("loaded_flank")
    numerics = {name: value for name, value in data.get("numerics", {}).items() if name not in _NO_GRID}
    lines = {"numerics": numerics, "misalignment": data.get("effects", {}).get("misalignment")}
    return _of(teeth), _of({**teeth, **lines})


_NO_GRID = ("wear_scheme", "wear_steps", "max_iterations", "threads", "accuracy", "peak_positions")


def _of(data: Table) -> str:
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()
