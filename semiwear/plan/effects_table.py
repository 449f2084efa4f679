"""The effects of a scene as a table: which run, why, their needs, where they act and their computing time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from xarray import DataTree

from semiwear.plain_text import table
from semiwear.scene import EFFECTS, EffectTable, Scene


def seconds_of_effects(last: DataTree) -> dict[str, float]:
    """Computing time of each effect in a result [s], and of the whole run under the empty name."""
    diagnostics = last["diagnostics"].to_dataset() if "diagnostics" in last.children else {}
    found: dict[str, float] = {}
    if "effect_seconds" in diagnostics:
        spent = diagnostics["effect_seconds"]
        found = dict(zip(spent["effect"].values.tolist(), spent.values.tolist(), strict=True))
    if "seconds" in diagnostics:
        found[""] = float(diagnostics["seconds"].sum())
    return found


def effects_table(scene: Scene, last: Mapping[str, float], costs: Mapping[str, str]) -> str:
    """Every effect, on or off.

    Parameters
    ----------
    scene : Scene
    last : mapping
        From `seconds_of_effects`; empty without an earlier run.
    costs : mapping
        Notes on the cost of effects that run, by name.
    """
    head = ("effect", "on", "acts in", "needs", "what and why")
    rows = []
    for name, kind in EFFECTS.items():
        own = scene.effects.get(name)
        told = "no table" if own is None else f"{_values(own)}{_cost(name, costs)}{_share(name, last)}"
        needs = ", ".join(_needs(name, kind, own)) or "-"
        rows.append((name, "no" if own is None else "yes", kind.acts_in, needs, f"{kind.title}: {told}"))
    return table(head, rows)


def _values(own: EffectTable) -> str:
    """The fields of an effect that are set, with the mark of those that hold their default."""
    told = []
    for field in fields(own):  # type: ignore[arg-type]
        value = getattr(own, field.name)
        if value is None:
            continue
        if isinstance(value, tuple):
            value = f"[{', '.join(f'{one:g}' for one in value)}]"
        shown = f"{value:g}" if isinstance(value, float) else str(value)
        told.append(f"{field.name} = {shown}{' (default)' if value == field.default else ''}")
    return ", ".join(told)


def _cost(name: str, costs: Mapping[str, str]) -> str:
    return f"; {costs[name]}" if name in costs else ""


def _needs(name: str, kind: type[EffectTable], own: EffectTable | None) -> list[str]:
    """Needs of an effect outside its own table."""
    needs = kind.needed_with(lambda name: None if own is None else getattr(own, name))
    return [key for key in needs if key != "wear" and not key.startswith(f"effects.{name}.")]


def _share(name: str, last: Mapping[str, float]) -> str:
    if name not in last or not last.get(""):
        return ""
    return f" ({100.0 * last[name] / last['']:.1f} % of the time of the last run)"
