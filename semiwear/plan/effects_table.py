"""The effects of a scene as a table: what runs, why, what it needs, where it acts and what it took."""

from __future__ import annotations

from collections.abc import Mapping

from xarray import DataTree

from semiwear.plan.choices import table
from semiwear.scene import EFFECTS, EffectTable, Scene

__all__ = ["effects_table", "seconds_of_effects"]


def seconds_of_effects(last: DataTree) -> dict[str, float]:
    """Seconds that effects took by themselves in a result, and those of the whole run under the empty name."""
    diagnostics = last["diagnostics"].to_dataset() if "diagnostics" in last.children else {}
    found: dict[str, float] = {}
    if "effect_seconds" in diagnostics:
        spent = diagnostics["effect_seconds"]
        found = dict(zip(spent["effect"].values.tolist(), spent.values.tolist(), strict=True))
    if "seconds" in diagnostics:
        found[""] = float(diagnostics["seconds"].sum())
    return found


def effects_table(scene: Scene, last: Mapping[str, float]) -> str:
    """Every effect, on or off.

    Parameters
    ----------
    scene : Scene
    last : mapping
        As `seconds_of_effects` gives it; empty without an earlier run.
    """
    head = ("effect", "on", "acts in", "needs", "what and why")
    rows = []
    for name, kind in EFFECTS.items():
        own = scene.effects.get(name)
        needs = ", ".join(_needs(kind, own)) or "-"
        if own is None:
            rows.append((name, "no", kind.acts_in, needs, f"{kind.title}: no table"))
            continue
        rows.append((name, "yes", kind.acts_in, needs, f"{kind.title}: [effects.{name}]{_share(name, last)}"))
    return table(head, rows)


def _needs(kind: type[EffectTable], own: EffectTable | None) -> list[str]:
    needs = [key for key in kind.needs if key != "wear"]
    for (field, value), keys in kind.needs_if.items():
        if own is not None and getattr(own, field) == value:
            needs += [key for key in keys if key not in needs]
    return needs


def _share(name: str, last: Mapping[str, float]) -> str:
    if name not in last or not last.get(""):
        return ""
    return f" ({100.0 * last[name] / last['']:.1f} % of the time of the last run)"
