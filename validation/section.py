"""What a section of the validation report is made of."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import xarray as xr

from validation.problems import Problems
from validation.progress import Progress


@dataclass(frozen=True)
class Section:
    """A finished section.

    Attributes
    ----------
    found : tuple of str
        Two or three sentences that say what was found, with numbers computed in this run.
    html : str
        Markup of what follows.
    datasets : mapping of str to Dataset
        The numbers behind it, by name; every variable with `units` and `long_name`.
    """

    found: tuple[str, ...]
    html: str
    datasets: Mapping[str, xr.Dataset] = field(default_factory=dict)


Build = Callable[[Problems, bool, Progress], Section]
"""From the problems, whether the report is the quick one, and who hears of progress, to the section."""


@dataclass(frozen=True)
class SectionPlan:
    """A section to be built: its name in addresses and file names, its title, and its function."""

    name: str
    title: str
    build: Build


@dataclass(frozen=True)
class Built:
    """A section, or what went wrong, with the seconds that it took.

    Attributes
    ----------
    plan : SectionPlan
    section : Section or None
        None where the function raised.
    error : str
        What it raised, in one line; empty otherwise.
    trace : str
        Where it was raised.
    processor_seconds, seconds : float
        Of this process, and of the clock on the wall.
    """

    plan: SectionPlan
    section: Section | None
    error: str
    trace: str
    processor_seconds: float
    seconds: float


def built(plan: SectionPlan, problems: Problems, quick: bool, progress: Progress) -> Built:
    """Build a section; whatever it raises becomes part of the answer, so that the others still appear."""
    started, cpu = time.perf_counter(), time.process_time()
    section, error, trace = None, "", ""
    try:
        section = plan.build(problems, quick, progress)
    except Exception as raised:
        error = f"{type(raised).__name__}: {raised}"
        trace = "".join(traceback.format_exception(raised))
    return Built(plan, section, error, trace, time.process_time() - cpu, time.perf_counter() - started)
