"""Unworn local safeties beside the standards' global ones: twenty pairs for stresses, twenty for film and heat."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from semiwear.report.markup import table
from validation import local_films, local_ratings
from validation.charts import COLOURS, MARKERS, Draw, card, cards
from validation.local_films import Mesh
from validation.problems import Problems
from validation.progress import Progress
from validation.section import Section
from validation.tables import dataset

TITLE = "Failure modes: local safeties beside global ones"
COARSE = {"numerics.face_slices": 21, "numerics.roll_positions": 16, "numerics.profile_points": 61}
COARSE |= {"numerics.harmonics": 5}
QUICK = 4
"""Pairs of either draw in a quick run, with `COARSE` numerics."""

CAUSES = {
    "S_H": "pitting: the standard takes 5 to 15 % off the stress for the contact ratio (Z_epsilon); relief deeper "
    "than the teeth bend concentrates load, helical lines without relief spread it",
    "S_H less Z_epsilon": "pitting without that factor of experience: what is left is how the load spreads",
    "S_F": "bending: local stress at the fillet of the compliant tooth against form and stress correction factors",
    "S_lambda": "micropitting: spur teeth share loads by their compliance instead of by thirds; slices within six "
    "contact widths of the tip edges that unmodified helical teeth press are not rated",
    "S_B": "scuffing by flash temperature: as micropitting",
    "S_intS": "scuffing by integral temperature: the standard's mean over the path stands for a rise that is alike "
    "on both sides of the pitch point, which it is not where the ratio is large",
}


class Rated(NamedTuple):
    """A safety of a pair, global and local."""

    symbol: str
    helical: bool
    whole: float
    local: float


def build(_: Problems, quick: bool, progress: Progress) -> Section:
    """Rate the drawn pairs both ways."""
    rated = [*_stresses(quick, progress), *_films(quick, progress)]
    words = {symbol: _words(symbol, rated) for symbol in CAUSES}
    found = (
        f"Local over global safety, unworn: {'; '.join(f'{symbol} {told}' for symbol, told in words.items())}.",
        "The greatest parts of the scatter are the contact ratio factor of pitting and the load at the tips of "
        "helical teeth, which the standards rate with the mean load.",
    )
    drawn = [
        card(f"modes-{_name(symbol)}", symbol, f"{cause[0].upper()}{cause[1:]}.", _scatter(symbol, rated))
        for symbol, cause in CAUSES.items()
    ]
    rows = [(symbol, *_ranges(symbol, rated), cause) for symbol, cause in CAUSES.items()]
    html = table("Local over global safeties", ("safety", "spur", "helical", "why they differ"), rows)
    data = dataset(
        {"rating": np.arange(len(rated))},
        {
            "symbol": ([one.symbol for one in rated], "1", "safety"),
            "helical": ([one.helical for one in rated], "1", "whether the pair is helical"),
            "global": ([one.whole for one in rated], "1", "safety by the standard, its load factors 1"),
            "local": ([one.local for one in rated], "1", "least safety of the unworn flanks"),
        },
    )
    return Section(found, html + cards(drawn), {"safeties": data})


def _stresses(quick: bool, progress: Progress) -> list[Rated]:
    """Pitting and bending of the pairs of `local_ratings`."""
    found = []
    for k, scene in enumerate(local_ratings.drawn_scenes(QUICK if quick else 20)):
        progress.note(f"pitting and bending, pair {k + 1}")
        one = local_ratings.compared(scene.replace(COARSE) if quick else scene)
        helical = k % 2 == 1
        whole, local = one.pitting
        found.append(Rated("S_H", helical, whole, local))
        found.append(Rated("S_H less Z_epsilon", helical, whole * one.iso.contact_ratio_factor, local))
        found += [Rated("S_F", helical, *safeties) for safeties in one.bending]
    return found


def _films(quick: bool, progress: Progress) -> list[Rated]:
    """Micropitting and scuffing of the pairs of `local_films`, which draws its helical ones last."""
    drawn = local_films.drawn()
    chosen: Sequence[Mesh] = (*drawn[: QUICK // 2], *drawn[-(QUICK // 2) :]) if quick else drawn
    few = {"numerics.face_slices": 31, "numerics.roll_positions": 24, "numerics.harmonics": 5}
    changes: Mapping[str, Any] = few if quick else {}
    found = []
    for k, mesh in enumerate(chosen):
        progress.note(f"micropitting and scuffing, pair {k + 1}")
        both = local_films.compared(mesh, changes)
        found += [Rated(symbol, mesh.helix > 0.0, *safeties) for symbol, safeties in both.items()]
    return found


def _ranges(symbol: str, rated: Sequence[Rated]) -> tuple[str, str]:
    """Mean and range of local over global safety, of spur and of helical pairs."""
    told = []
    for helical in (False, True):
        own = np.array([one.local / one.whole for one in rated if (one.symbol, one.helical) == (symbol, helical)])
        told.append(f"{own.mean():.2f} ({own.min():.2f} to {own.max():.2f})")
    return told[0], told[1]


def _words(symbol: str, rated: Sequence[Rated]) -> str:
    spur, helical = _ranges(symbol, rated)
    return f"spur {spur}, helical {helical}"


def _name(symbol: str) -> str:
    return symbol.replace(" ", "-").replace("_", "")


def _scatter(symbol: str, rated: Sequence[Rated]) -> Draw:
    def draw(ax: Any) -> None:
        own = [one for one in rated if one.symbol == symbol]
        for k, name in enumerate(("spur", "helical")):
            some = [one for one in own if one.helical == bool(k)]
            points = [one.whole for one in some], [one.local for one in some]
            ax.plot(*points, MARKERS[k], color=COLOURS[k], label=name)
        reach = [0.0, 1.05 * max(max(one.whole, one.local) for one in own)]
        ax.plot(reach, reach, color="#888888", linewidth=0.8)
        ax.set(xlim=reach, ylim=reach, xlabel="Global safety, by the standard (1)", ylabel="Local safety (1)")
        ax.legend(loc="upper left")

    return draw
