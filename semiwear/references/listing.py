"""Named data for people who choose: a table of each kind with values, conditions and sources."""

from __future__ import annotations

from semiwear.plain_text import folded, table
from semiwear.references.citations import titled
from semiwear.references.named_data import MATERIALS, OILS, WEAR, named_sets, oil_at
from semiwear.untyped import Table

KINDS = (MATERIALS, WEAR, OILS)
"""Kinds of named data, in the order in which they are told."""

_HOW = {
    MATERIALS: 'Materials: material.gear = "POM" in a scene, or data = "POM" in [material.gear].',
    WEAR: 'Wear coefficients: data = "NAME" in [wear], or data = {pinion = "NAME", gear = "NAME"}. What wears is '
    "named first. A test of two specimens is no gear: take them to compare, and calibrate on worn gears.",
    OILS: 'Oils: data = "NAME" and oil_temperature_C in [effects.lubrication] or [effects.friction].',
}
_TEMPERATURES = (40.0, 80.0)


def named_text(kinds: tuple[str, ...] = KINDS) -> str:
    """Tables of named data, each with how a scene names one, and their sources."""
    parts, sources = [], []
    for kind in kinds:
        sets = named_sets(kind)
        parts.append(f"{folded(_HOW[kind])}\n\n{_TABLES[kind](sets)}")
        sources += [one["source"] for one in sets.values()]
    told = "\n".join(folded(titled(key)) for key in dict.fromkeys(sources))
    return "\n\n".join([*parts, f"Sources (`semiwear cite` writes them as BibTeX):\n{told}"])


def _range(low_high: list[float] | None) -> str:
    return "" if low_high is None else f"{low_high[0]:g} to {low_high[1]:g}"


def _materials(sets: dict[str, Table]) -> str:
    head = ("name", "E [MPa]", "published", "nu", "source", "holds for")
    return table(
        head,
        [
            (
                name, f"{one['youngs_modulus_MPa']:g}", _range(one.get("youngs_modulus_range_MPa")),
                f"{one['poissons_ratio']:g}", one["source"], one["conditions"],
            )
            for name, one in sets.items()
        ],
    )  # fmt: skip


def _wear(sets: dict[str, Table]) -> str:
    head = ("name", "k [mm2/N]", "published", "known", "source", "test")
    return table(
        head,
        [
            (
                name, f"{one['coefficient_mm2_per_N']:g}", _range(one.get("range_mm2_per_N")),
                "roughly" if one["rough"] else "as given", one["source"],
                f"{one['of']} against {one['against']}; {one['conditions']}",
            )
            for name, one in sets.items()
        ],
    )  # fmt: skip


def _oils(sets: dict[str, Table]) -> str:
    head = ("name", *(f"mPa s at {t:g} C" for t in _TEMPERATURES), "source", "what")
    rows = []
    for name, one in sets.items():
        viscosities = (f"{oil_at(one, t)['viscosity_mPas']:.3g}" for t in _TEMPERATURES)
        rows.append((name, *viscosities, one["source"], one["title"]))
    return table(head, rows)


_TABLES = {MATERIALS: _materials, WEAR: _wear, OILS: _oils}
