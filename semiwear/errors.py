"""Errors of semiwear, whose messages give the fault and the remedy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from xarray import DataTree


class SemiwearError(Exception):
    """Base class of the errors that semiwear raises."""


@dataclass(frozen=True)
class Problem:
    """A fault of a scene or of another input.

    Attributes
    ----------
    field : str
        Dotted key, e.g. ``"gear_pair.module_mm"``, or the name of an argument or an option.
    value : object
        Value found there (``None`` when it is missing).
    allowed : str
        The allowed range or choice, in words.
    fix : str
        The likely remedy.
    default : bool
        Whether the value is the field's default, not given in the scene.
    """

    field: str
    value: object
    allowed: str
    fix: str = ""
    default: bool = False

    def __str__(self) -> str:
        found = "missing" if self.value is None else f"found {self.value!r}"
        if self.default and self.value is not None:
            found = f"left out, its default here is {self.value!r}"
        remedy = f" -> {self.fix}" if self.fix else ""
        return f"{self.field}: {found}; allowed: {self.allowed}{remedy}"


class SceneError(SemiwearError, ValueError):
    """A scene or another input cannot be used.

    Attributes
    ----------
    problems : tuple of Problem
        Every reason at once.
    scene_name : str
        Name of the input, with which the message begins.
    """

    NAMELESS = "scene"

    def __init__(self, problems: Sequence[Problem], scene_name: str = NAMELESS):
        self.problems, self.scene_name = tuple(problems), scene_name
        count = len(self.problems)
        lines = "\n".join(f"  {k + 1}. {problem}" for k, problem in enumerate(self.problems))
        super().__init__(f"{scene_name}: {count} problem{'s' if count != 1 else ''}\n{lines}")

    @classmethod
    def of(cls, field: str, value: object, allowed: str, fix: str = "") -> SceneError:
        """An error with a single problem, of a field of the scene or an option of the command line."""
        return cls([Problem(field, value, allowed, fix)], "command line" if field.startswith("-") else cls.NAMELESS)


class Collected:
    """Context that adds the problems of a `SceneError` to others, with which they are reported."""

    def __init__(self, problems: list[Problem]):
        self._problems = problems

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> bool:
        self._problems += error.problems if isinstance(error, SceneError) else ()
        return isinstance(error, SceneError)


class ConvergenceError(SemiwearError, RuntimeError):
    """An iteration did not reach its tolerance; the message gives the place and a remedy.

    Attributes
    ----------
    result : DataTree or None
        Finished part of a run of several steps; None if no step was finished.
    """

    def __init__(self, message: str, result: DataTree | None = None):
        super().__init__(message)
        self.result = result


class EndlessWearError(ConvergenceError):
    """Wear does not reach the depth at which a life or a run ends: the flank wears no further.

    Attributes
    ----------
    life : bool
        Whether it is the depth of ``[effects.run_life]``, and the run itself is finished.
    """

    def __init__(self, message: str, result: DataTree | None = None, *, life: bool = False):
        super().__init__(message, result)
        self.life = life


class ResultFileError(SemiwearError, ValueError):
    """A result file is damaged, foreign or of another version."""


class MissingExtraError(SemiwearError, ImportError):
    """An optional package is needed; the message names the extra to install."""

    def __init__(self, package: str, extra: str, purpose: str):
        super().__init__(f"{purpose} needs {package}: pip install 'semiwear[{extra}]'")
