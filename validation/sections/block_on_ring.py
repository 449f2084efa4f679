"""Block on ring: a published wear test in the plane, simulated and measured."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from semiwear.closed_forms.hertz import line_contact_half_width, line_contact_pressure
from semiwear.report.markup import figure_text, table
from validation.charts import COLOURS, MARKERS, card, cards
from validation.problems import BlockOnRing
from validation.standing_contact import StandingContact
from validation.tables import dataset, with_unit

RING_STRIPS = 160
RING_STEPS = (1, 2, 5, 10, 20)
"""Implicit steps for every 800 m."""


@dataclass(frozen=True)
class RingRun:
    """The block on ring with implicit steps.

    Attributes
    ----------
    place : (strip,) array [mm]
    wear : (distance, strip) array [um]
    pressure : float [MPa]
        Peak on the unworn block.
    seconds : float
    """

    place: np.ndarray
    wear: np.ndarray
    pressure: float
    seconds: float

    @property
    def depths(self) -> np.ndarray:
        """Greatest depth at each distance [um]."""
        return np.asarray(self.wear.max(axis=1))

    @property
    def half_widths(self) -> np.ndarray:
        """Half-width of the scar at each distance [mm]: to where the depth falls to nothing."""
        cell = self.place[1] - self.place[0]
        return np.asarray(0.5 * cell * (self.wear > 1e-6 * self.wear.max()).sum(axis=1))


def ring_run(ring: BlockOnRing, strips: int, steps_each: int, half_length: float = 1.6) -> RingRun:
    """Wear the block to all published distances, with so many implicit steps between two of them."""
    contact = StandingContact(ring.ring_radius, ring.line_load, ring.modulus, ring.coefficient, half_length, strips)
    started = time.process_time()
    wear = contact.run(tuple(1e3 * distance for distance in ring.distances), steps_each)
    seconds = time.process_time() - started
    return RingRun(contact.place, 1e3 * wear, float(contact.pressure(np.zeros(strips)).max()), seconds)


def against_tests(ring: BlockOnRing, run: RingRun) -> tuple[float, float]:
    """Root mean square of the measured profiles about their mean, and about ours [um]."""
    ours = np.interp(ring.measured_place, run.place, run.wear[-1])
    own = ring.measured - ring.measured.mean(axis=0)
    return float(np.sqrt((own**2).mean())), float(np.sqrt(((ring.measured - ours) ** 2).mean()))


def ring_part(ring: BlockOnRing, runs: Mapping[int, RingRun]) -> str:
    finest = runs[max(runs)]
    hertz = float(line_contact_pressure(np.array(ring.line_load), np.array(1 / ring.ring_radius), ring.modulus))
    width = float(line_contact_half_width(np.array(ring.line_load), np.array(1 / ring.ring_radius), ring.modulus))
    rows = [
        (
            with_unit(distance, "m"),
            f"{finest.depths[k]:.3f}",
            f"{ring.umeshmotion[k]:.3f}",
            f"{100 * (finest.depths[k] / ring.umeshmotion[k] - 1):+.2f} %",
            f"{ring.rigid[k]:.3f}",
            f"{finest.half_widths[k]:.2f}",
            f"{ring.umeshmotion_half_width[k]:.2f}",
        )
        for k, distance in enumerate(ring.distances)
    ]
    head = ("sliding distance", "depth, ours [µm]", "UMESHMOTION [µm]", "ours against it", "rigid closed form [µm]",
            "scar's half-width, ours [mm]", "UMESHMOTION [mm]")  # fmt: skip
    text = (
        "<h3>Block on ring</h3><p>A steel ring of 20 mm slides on a steel block, which alone wears (Cruzado, Zabala, "
        "Urchegui and Gomez 2010; figures of Abaqus with UMESHMOTION published as data with LevelSetWear, I. "
        "Llavori, Mondragon Unibertsitatea, BSD 3-Clause). Ours: strips of a half-space, the active set of fidelity "
        f"<code>line</code>, and its implicit wear step; {RING_STRIPS} strips of "
        f"{figure_text(1e3 * float(finest.place[1] - finest.place[0]), 3)} µm, {max(runs)} steps for every published "
        f"distance. Unworn, the peak pressure is {finest.pressure:.1f} MPa where Hertz has {hertz:.1f} MPa on a "
        f"half-width of {1e3 * width:.0f} µm.</p>"
    )
    steps = [
        (str(steps), *(f"{depth:.3f}" for depth in run.depths), with_unit(run.seconds, "s", 2))
        for steps, run in runs.items()
    ]
    step_head = ("implicit steps a distance", *(f"{distance:g} m [µm]" for distance in ring.distances), "processor")

    def profile(ax: Any) -> None:
        for k, values in enumerate(ring.measured):
            ax.plot(ring.measured_place, -values, MARKERS[k], color="#888888", label=f"measured, test {k + 1}")
        ax.plot(finest.place, -finest.wear[-1], color=COLOURS[0], label="ours")
        ax.axhline(-ring.umeshmotion[-1], color=COLOURS[1], linestyle="--", label="UMESHMOTION, depth")
        ax.set_xlabel("Place (mm)")
        ax.set_ylabel("Depth (µm)")
        ax.set_ylim(-52, 22)
        ax.legend(loc="upper center", ncols=2)

    def course(ax: Any) -> None:
        ax.plot(ring.distances, ring.umeshmotion, "s", color=COLOURS[1], markersize=8, fillstyle="none",
                label="UMESHMOTION")  # fmt: skip
        ax.plot(ring.distances, finest.depths, "o-", color=COLOURS[0], label=f"ours, {max(runs)} steps each")
        one = runs[min(runs)]
        ax.plot(ring.distances, one.depths, "^:", color=COLOURS[2], label="ours, one step each")
        ax.set_xlabel("Sliding distance (m)")
        ax.set_ylabel("Greatest depth (µm)")
        ax.set_xlim(left=0)
        ax.set_ylim(bottom=0)
        ax.legend(loc="lower right")

    drawn = [
        card("ring-profile", "Worn profile after 3600 m", "Three measured tests, and ours.", profile),
        card("ring-course", "Depth over sliding distance", "Ours beside Abaqus with UMESHMOTION.", course),
    ]
    return (
        text
        + cards(drawn)
        + table("Depth and width of the scar", head, rows)
        + table("What the number of steps changes", step_head, steps)
    )


def depths_data(ring: BlockOnRing, runs: Mapping[int, RingRun]) -> xr.Dataset:
    return dataset(
        {"steps_each": list(runs), "distance_m": list(ring.distances)},
        {
            "depth": ([run.depths for run in runs.values()], "um", "greatest wear depth"),
            "half_width": ([run.half_widths for run in runs.values()], "mm", "half-width of the scar"),
            "umeshmotion": ([list(ring.umeshmotion)] * len(runs), "um", "published depth, Abaqus with UMESHMOTION"),
            "seconds": ([run.seconds for run in runs.values()], "s", "processor time"),
        },
    )


def profile_data(ring: BlockOnRing, run: RingRun) -> xr.Dataset:
    tests = {
        f"measured_{k + 1}": (values, "um", f"measured depth, test {k + 1}") for k, values in enumerate(ring.measured)
    }
    ours = np.interp(ring.measured_place, run.place, run.wear[-1])
    return dataset({"place_mm": ring.measured_place}, {"ours": (ours, "um", "depth, ours"), **tests})
