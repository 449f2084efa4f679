"""The scenes of a sweep: checked combinations, and the solutions and geometries that they share."""

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

_COEFFICIENT = "wear.coefficient_mm2_per_N"
_ENDS = frozenset({"/life/meshes_to_end", "/life/hours_to_end", "/life/ended_by"})
_MOST_SHOWN = 20


@dataclass(frozen=True)
class Task:
    """A scene to be solved.

    Attributes
    ----------
    key : str
        Digest of everything but the code on which the solution depends.
    scene : Scene
    measure : Measure
    compared : Compared, optional
        Given if its run is compared with others of nearly the same scene.
    """

    key: str
    scene: Scene
    measure: Measure
    compared: Compared | None = None


@dataclass(frozen=True)
class Member:
    """A scene of a sweep: the source of its numbers, or the reason why it has none.

    Attributes
    ----------
    key : str
        Key of the task that solves it; empty if the scene is refused.
    stretch : float
        Number of meshes over that of the task.
    refused : str
        Faults of the combination.
    """

    key: str
    stretch: float = 1.0
    refused: str = ""


def scenes_of(scene: Scene, variation: Variation) -> list[Scene | SceneError]:
    """Each scene of a sweep, or its error.

    Raises
    ------
    SceneError
        If every combination is illegal.
    """
    base = replace(scene, _check=None if scene._check is None else _remembered(scene._check, scene))
    found: list[Scene | SceneError] = []
    for changes in variation.changes():
        try:
            changed = replace(base.replace(changes), _check=scene._check)
            if changed.wear is None:
                raise SceneError.of("wear", None, "a table [wear]", "loaded_contact is for scenes without wear")
            found.append(changed)
        except SceneError as error:
            found.append(error)
    errors = [error for error in found if isinstance(error, SceneError)]
    if len(errors) == len(found):
        problems = list({str(problem): problem for error in errors for problem in error.problems}.values())
        raise SceneError(problems[:_MOST_SHOWN], "sweep, every scene")
    return found


def _remembered(check: Callable[[Scene], Iterable[Problem]], base: Scene) -> Callable[[Scene], list[Problem]]:
    """Limits of the teeth, found once for scenes that differ only in fields without influence on them.

    These are load, material, speed and duration of wear, and effects that name no file.
    """

    @lru_cache(maxsize=256)
    def found(geometry: Scene) -> tuple[Problem, ...]:
        return tuple(check(geometry))

    def problems(scene: Scene) -> list[Problem]:
        wear = scene.wear
        if wear is not None and base.wear is not None:
            wear = replace(wear, coefficient_mm2_per_N=base.wear.coefficient_mm2_per_N, until=base.wear.until)
        # effects influence limits only by files with deviations
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
    """Scenes of a sweep and the tasks that solve them; shared solutions are solved once.

    Scenes that differ only in the wear coefficient share a solution if that is exact (`shared_solution`).

    Raises
    ------
    SceneError
        If every combination is illegal.
    """
    members: list[Member] = []
    tasks: dict[str, Task] = {}
    varied = {axis.key for axis in variation.axes}
    for own in scenes_of(scene, variation):
        if isinstance(own, SceneError):
            members.append(Member("", refused="; ".join(str(problem) for problem in own.problems)))
            continue
        solved, stretch = shared_solution(own, scene, measure) if varied & {_COEFFICIENT, "wear"} else (own, 1.0)
        plain = replace(
            solved, title="", reference=None, numerics=replace(solved.numerics, threads=None), _check=None
        )
        key = _digest(plain, measure)
        threads = solved.numerics.threads
        tasks.setdefault(key, Task(key, replace(plain, numerics=replace(plain.numerics, threads=threads)), measure))
        members.append(Member(key, stretch))
    return members, tasks


def shared_solution(scene: Scene, base: Scene, measure: Measure) -> tuple[Scene, float]:
    """The scene with the wear coefficient of another one, and the ratio of its number of meshes to the other's.

    Wear depends on the product k N of the coefficient and the number of meshes: every law of the coefficient is a
    factor on k N. A run that ends at given depths, and a life, therefore have the same k N for every k, and the same
    contact. A run of a given number of meshes does not; nor do two bodies with another ratio of their coefficients.
    Such a scene is returned unchanged; so is one whose damage by failure modes is measured: Miner's sum depends on
    meshes N, not on k N.
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
    """Whether measured quantities depend on failure modes that the scene rates."""
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
    content = [scene.to_toml(), sorted(file_digests(scene.to_dict()).items()), measure.variables, measure.last]
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:32]


def shared_by(task: Task) -> tuple[str, str]:
    """`geometry_of` a task's scene; for runs with interpolated prisms, digests of their course."""
    course = None if task.compared is None else task.compared.course
    if course is None:
        return geometry_of(task.scene)
    ends = hashlib.sha256(repr((course.at, course.beside)).encode()).hexdigest()
    return ends, ends


def geometry_of(scene: Scene) -> tuple[str, str]:
    """Digests of a scene's teeth and of its contact lines, which scenes with equal digests share."""
    data: Table = scene.to_dict()
    teeth = {"gear_pair": data["gear_pair"], "material": data.get("material"), "loaded": data["operation"]}
    teeth["loaded"] = data["operation"].get("loaded_flank")
    numerics = {name: value for name, value in data.get("numerics", {}).items() if name not in _NO_GRID}
    lines = {"numerics": numerics, "misalignment": data.get("effects", {}).get("misalignment")}
    return _of(teeth), _of({**teeth, **lines})


_NO_GRID = ("wear_scheme", "wear_steps", "max_iterations", "threads", "accuracy", "peak_positions")


def _of(data: Table) -> str:
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()
