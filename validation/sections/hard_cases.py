"""Hard cases: every named one is solved in the run, or refused; and where explicit wear steps become unstable."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from semiwear.report.markup import figure_text, table
from validation.charts import COLOURS, Draw, card, cards
from validation.hard_cases import HARD_EXAMPLES, Outcome, attempt
from validation.problems import Problems
from validation.progress import Progress
from validation.section import Section
from validation.standing_contact import EXPLICIT_LIMIT, StandingContact, roughness_after
from validation.tables import dataset, percent, power, text_table

TITLE = "Hard cases"
COARSE = 0.05
"""Change of a load share by which a grid is told to be too coarse for a case."""
FACTORS = (0.5, 0.9, 0.97, 1.03, 1.1, 1.5, 3.0, 10.0, 100.0, 1000.0)
"""Wear steps over the longest that is stable when explicit."""


def build(problems: Problems, quick: bool, progress: Progress) -> Section:
    """Solve all hard cases at both fidelities, and wear standing contacts with steps of many lengths."""
    outcomes = []
    for example in HARD_EXAMPLES:
        if quick and example.slow:
            continue
        progress.note(f"{example.kind}, {example.name}")
        outcomes += [attempt(example, fidelity, 1 if quick else 2) for fidelity in ("line", "patch")]
    progress.note("explicit and implicit wear steps")
    grown = {kind: np.array([roughness_after(f * EXPLICIT_LIMIT, implicit=kind == "implicit") for f in FACTORS])
             for kind in ("explicit", "implicit")}  # fmt: skip
    ring = _ring(problems)
    html = _tables(outcomes, quick) + _stability(grown, ring)
    data = {"examples": _examples(outcomes), "stability": _growth(grown)}
    return Section(_found(outcomes, grown), html, data)


# ---- examples


def _found(outcomes: Sequence[Outcome], grown: dict[str, np.ndarray]) -> tuple[str, ...]:
    solved = [one for one in outcomes if not one.error]
    bad = [one for one in outcomes if not one.as_it_should_be]
    first = (
        f"{len(outcomes)} runs of {len(outcomes) // 2} hard cases: {len(solved)} were solved, "
        f"{len(outcomes) - len(solved)} refused with an error that says what to change; "
    )
    if bad:
        names = "; ".join(sorted({f"{one.example.kind}, {one.example.name}, {one.fidelity}" for one in bad}))
        first += f"{len(bad)} did not come out as they should: {names}."
    else:
        first += "all came out as they should."
    clean = all(one.finite and one.non_negative for one in solved)
    second = (
        f"Of those solved, the torque is balanced to {power(max(one.balance for one in solved))} and gap times "
        f"pressure vanishes to {power(max(one.complementarity for one in solved))} at worst; "
        + ("every number is finite, and no pressure or wear negative." if clean else "not every number is finite.")
    )
    coarse = [one for one in solved if one.refinements and one.refinements[-1] > COARSE]
    worst = max((one for one in solved if one.refinements), key=lambda one: one.refinements[-1])
    second += (
        f" The last doubling of the small grid changes a load share by more than {COARSE:g} in {len(coarse)} runs, "
        f"most by {worst.refinements[-1]:.2f} ({worst.example.name}, {worst.fidelity})."
    )
    stable = [f for f, growth in zip(FACTORS, grown["explicit"], strict=True) if growth < 1.0]
    implicit = "all" if (grown["implicit"] < 1.0).all() else "not all"
    third = (
        f"Explicit wear steps smooth a rough contact up to {max(stable, default=0.0):g} times the theoretical limit "
        f"of k Δs = {EXPLICIT_LIMIT:.3f} Δx/E* and roughen it from "
        f"{min(set(FACTORS) - set(stable), default=np.inf):g} times on; implicit ones smooth it at {implicit} of "
        f"the {len(FACTORS)} lengths tried, up to {max(FACTORS):g} times the limit."
    )
    return first, second, third


def _tables(outcomes: Sequence[Outcome], quick: bool) -> str:
    solved, refused = [one for one in outcomes if not one.error], [one for one in outcomes if one.error]
    times = "once" if quick else "twice"
    head = ("what is hard", "fidelity", "greatest pressure [MPa]", "load balance", "complementarity",
            "answer to load", "finer grids", "as it should be")  # fmt: skip
    rows = [
        (
            f"{one.example.kind}: {one.example.name}",
            one.fidelity,
            figure_text(one.pressure, 3),
            power(one.balance),
            power(one.complementarity),
            "–" if np.isnan(one.continuity) else f"{one.continuity:.2f}",
            ", then ".join(f"{change:.3f}" for change in one.refinements) or "–",
            "yes" if one.as_it_should_be else "NO",
        )
        for one in solved
    ]
    marks = ["agree" if one.as_it_should_be else "disagree" for one in solved]
    text = (
        "<h3>Solved</h3><p>The small scene has 21 slices, 8 roll positions and rigid teeth. Greatest pressure "
        "includes edges, whose pressure depends on the grid. Load balance and complementarity are residuals relative "
        "to the load and to pressure times approach. Answer to load: greatest change of a line load over the "
        "greatest line load, divided by the relative change of torque, a millionth; values of about 1 mean that "
        "loads are in proportion. Finer grids: greatest change of a load share when slices and flank points are "
        f"doubled {times}.</p>"
    )
    html = text + table("Hard cases that are solved", head, rows, marks)
    refused_head = ("what is hard", "case", "fidelity", "error", "as it should be")
    errors = [
        (one.example.kind, one.example.name, one.fidelity, one.error, "yes" if one.as_it_should_be else "NO")
        for one in refused
    ]
    marks = ["agree" if one.as_it_should_be else "disagree" for one in refused]
    return html + "<h3>Refused</h3>" + text_table(table("Hard cases that are refused", refused_head, errors, marks))


def _examples(outcomes: Sequence[Outcome]) -> xr.Dataset:
    return dataset(
        {"run": np.arange(len(outcomes))},
        {
            "kind": ([one.example.kind for one in outcomes], "1", "what is hard"),
            "case": ([one.example.name for one in outcomes], "1", "case"),
            "fidelity": ([one.fidelity for one in outcomes], "1", "fidelity"),
            "as_it_should_be": ([one.as_it_should_be for one in outcomes], "1", "whether it came out as it should"),
            "error": ([one.error for one in outcomes], "1", "error, empty where solved"),
            "finite": ([one.finite for one in outcomes], "1", "whether all numbers are finite"),
            "non_negative": ([one.non_negative for one in outcomes], "1", "no tension, no negative wear"),
            "load_balance": ([one.balance for one in outcomes], "1", "residual of the torque"),
            "complementarity": ([one.complementarity for one in outcomes], "1", "residual of gap times pressure"),
            "pressure": ([one.pressure for one in outcomes], "MPa", "greatest pressure, edges included"),
            "continuity": ([one.continuity for one in outcomes], "1", "answer of line loads to torque"),
            "refinement": (
                [one.refinements[-1] if one.refinements else np.nan for one in outcomes],
                "1",
                "greatest change of a load share at the last doubling of the grid",
            ),
        },
    )


# ---- stability


def _ring(problems: Problems) -> dict[float, dict[str, np.ndarray]]:
    """The block on ring after 120 steps below and above the limit: pressures [MPa], with their places [mm].

    Wear hides what grows: a strip that is worn too deep bears nothing, and does not wear until it bears again.
    """
    ring = problems.block_on_ring
    contact = StandingContact(ring.ring_radius, ring.line_load, ring.modulus, ring.coefficient, 1.0, 100)
    found: dict[float, dict[str, np.ndarray]] = {}
    for factor in (0.9, 1.2):
        distance = 120 * factor * contact.explicit_limit
        found[factor] = {
            kind: contact.pressure(contact.run((distance,), 120, implicit=kind == "implicit")[-1])
            for kind in ("explicit", "implicit")
        }
        found[factor]["place"] = contact.place
    return found


def _stability(grown: dict[str, np.ndarray], ring: dict[float, dict[str, np.ndarray]]) -> str:
    def growth(ax: Any) -> None:
        for kind, marker, colour in (("explicit", "o", COLOURS[1]), ("implicit", "s", COLOURS[0])):
            ax.loglog(FACTORS, np.maximum(grown[kind], 1e-12), marker=marker, color=colour, label=kind)
        ax.axhline(1.0, color="#555555", linewidth=1.0)
        ax.axvline(1.0, color="#555555", linewidth=1.0, linestyle=":")
        ax.set_xlabel("Wear step over the explicit limit")
        ax.set_ylabel("Roughness after 60 steps")
        ax.legend(loc="center right")

    def profile(factor: float) -> Draw:
        def draw(ax: Any) -> None:
            one = ring[factor]
            ax.plot(one["place"], one["explicit"], color=COLOURS[1], linewidth=1.0, marker=".", label="explicit")
            ax.plot(one["place"], one["implicit"], color=COLOURS[0], label="implicit")
            ax.set_xlabel("Place (mm)")
            ax.set_ylabel("Pressure (MPa)")
            ax.set_xlim(-0.4, 0.4)
            ax.set_ylim(bottom=0.0)
            ax.legend(loc="upper right")

        return draw

    off = {
        factor: float(np.abs(one["explicit"] - one["implicit"]).max() / one["implicit"].max())
        for factor, one in ring.items()
    }
    idle = {factor: int(((one["explicit"] <= 0.0) & (one["implicit"] > 0.0)).sum()) for factor, one in ring.items()}
    bearing = {factor: int((one["implicit"] > 0.0).sum()) for factor, one in ring.items()}
    intro = (
        "<h3>Where explicit wear steps become unstable</h3><p>A contact that stands still is cut into strips of "
        f"width Δx and worn in steps of k Δs. Theory: explicit steps are stable up to k Δs = 16 G/π² Δx/E* = "
        f"{EXPLICIT_LIMIT:.3f} Δx/E* (G: Catalan's constant), implicit ones always. A wave from strip to strip "
        "grows or decays accordingly. On the block on ring, explicit pressures are off the implicit ones by up to "
        f"{percent(off[0.9])} of the greatest at 0.9 times the limit, and by {percent(off[1.2])} at 1.2 times, where "
        f"{idle[1.2]} of the scar's {bearing[1.2]} strips bear nothing, against {idle[0.9]} of {bearing[0.9]}. What "
        "grows stops there: a strip that is worn too deep does not wear until it bears again.</p>"
    )
    drawn = [
        card("growth", "A wave from strip to strip", "Above 1 it grows: the steps are unstable.", growth),
        *(
            card(
                f"ring{k}",
                f"Block on ring, steps of {factor:g} times the limit",
                "Pressure after 120 steps: explicit ones beside implicit ones of the same length.",
                profile(factor),
            )
            for k, factor in enumerate(ring)
        ),
    ]
    return intro + cards(drawn)


def _growth(grown: dict[str, np.ndarray]) -> xr.Dataset:
    return dataset(
        {"step": np.array(FACTORS)},
        {kind: (values, "1", f"growth of a wave in 60 {kind} steps") for kind, values in grown.items()},
        f"step: k ds over {EXPLICIT_LIMIT:.6f} dx/E*",
    )
