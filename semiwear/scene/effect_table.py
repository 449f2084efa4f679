"""Base class of the tables of effects: title, stage, needs, range of validity, references."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import chain
from typing import ClassVar, Protocol, TypeAlias

from semiwear.untyped import Table, Value

NeedsIf: TypeAlias = Mapping[tuple[str, Value], tuple[str, ...]]


class ScreenedScene(Protocol):
    """Part of a `Scene` that a screening uses: its operation and its wear."""

    @property
    def operation(self) -> Value:
        """Table ``[operation]``."""

    @property
    def wear(self) -> Value:
        """Table ``[wear]``, or None."""


class EffectTable:
    """Base class of the tables under ``[effects]``: an effect is active if and only if its table is present.

    Attributes
    ----------
    title : str
        A few words, for printed tables.
    acts_in : str
        The stage: ``"geometry"``, ``"meshing"``, ``"compliance"``, ``"contact"``, ``"wear"`` or ``"results"``.
    needs : tuple of str
        Dotted keys of the fields and tables that must be present.
    needs_if : mapping
        From (field of this table, value) to the dotted keys needed only with that value.
    validity : str
        Range of validity in words.
    references : tuple of str
        Author, year and subject.
    """

    title: ClassVar[str]
    acts_in: ClassVar[str]
    needs: ClassVar[tuple[str, ...]] = ()
    needs_if: ClassVar[NeedsIf] = {}
    validity: ClassVar[str]
    references: ClassVar[tuple[str, ...]]

    @classmethod
    def needed_with(cls, value_of: Callable[[str], Value]) -> tuple[str, ...]:
        """Dotted keys that must be present; `value_of` returns the value of a field of the table by name."""
        further = (keys for (name, value), keys in cls.needs_if.items() if value_of(name) == value)
        return tuple(dict.fromkeys([*cls.needs, *chain.from_iterable(further)]))

    @staticmethod
    def screening_table(scene: ScreenedScene) -> Table:
        """Fields with which a screening adds this effect; empty for its defaults."""
        return {}
