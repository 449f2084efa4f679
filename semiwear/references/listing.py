"""List of the named data: a table of each kind with values, conditions and sources."""

from __future__ import annotations

from semiwear.plain_text import folded, table
from semiwear.references.citations import titled
from semiwear.references.named_data import MATERIALS, OILS, WEAR, named_sets, oil_at
from semiwear.untyped import Table

KINDS = (MATERIALS, WEAR, OILS)
"""Kinds of named data, in the order of the list."""

_HOW = {
    MATERIALS: 'Materials: material.gear = "POM" in a scene, or data = "POM" in [material.gear].',
    WEAR: 'Wear coefficients: data = "NAME" in [wear], or data = {pinion = "NAME", gear = "NAME"}. The material that '
    "wears is named first. Tests of specimens differ from gears: use them to compare, and calibrate on worn gears.",
    OILS: 'Oils: data = "NAME" and oil_temperature_C in [effects.lubrication] or [effects.friction].',
}
_TEMPERATURES = (40.0, 80.0)


def named_text(kinds: tuple[str, ...] = KINDS) -> str:
    """Tables of named data, each with its use in a scene, and their sources."""
    parts, sources = [], []
    for kind in kinds:
        sets = named_sets(kind)
        parts.append(f"{folded(_HOW[kind])}\n\n{_TABLES[kind](sets)}")
        sources += [entry["source"] for entry in sets.values()]
    citations = "\n".join(folded(titled(key)) for key in dict.fromkeys(sources))
    return "\n\n".join([*parts, f"Sources (`semiwear cite` writes them as BibTeX):\n{citations}"])


def _range(low_high: list[float] | None) -> str:
    return "" if low_high is None else f"{low_high[0]:g} to {low_high[1]:g}"


def _materials(sets: dict[str, Table]) -> str:
    head = ("name", "E [MPa]", "published", "nu", "source", "holds for")
    return table(
        head,
        [
            (
                name, f"{entry['youngs_modulus_MPa']:g}", _range(entry.get("youngs_modulus_range_MPa")),
                f"{entry['poissons_ratio']:g}", entry["source"], entry["conditions"],
            )
            for name, entry in sets.items()
        ],
    )  # fmt: skip


def _wear(sets: dict[str, Table]) -> str:
    head = ("name", "k [mm2/N]", "published", "known", "source", "test")
    return table(
        head,
        [
            (
                name, f"{entry['coefficient_mm2_per_N']:g}", _range(entry.get("range_mm2_per_N")),
                "roughly" if entry["rough"] else "as given", entry["source"],
                f"{entry['of']} against {entry['against']}; {entry['conditions']}",
            )
            for name, entry in sets.items()
        ],
    )  # fmt: skip


def _oils(sets: dict[str, Table]) -> str:
    head = ("name", *(f"mPa s at {t:g} C" for t in _TEMPERATURES), "source", "oil")
    rows = []
    for name, entry in sets.items():
        viscosities = (f"{oil_at(entry, t)['viscosity_mPas']:.3g}" for t in _TEMPERATURES)
        rows.append((name, *viscosities, entry["source"], entry["title"]))
    return table(head, rows)


_TABLES = {MATERIALS: _materials, WEAR: _wear, OILS: _oils}
