"""Sections of the validation report, in their order."""

from __future__ import annotations

from validation.section import SectionPlan
from validation.sections import (
    accuracy_time,
    closed_forms,
    failure_modes,
    finite_elements,
    hard_cases,
    helical_pairs,
    paper,
    peers,
    wear_schemes,
)

__all__ = ["SECTIONS"]

SECTIONS: tuple[SectionPlan, ...] = (
    SectionPlan("accuracy_time", accuracy_time.TITLE, accuracy_time.build),
    SectionPlan("wear_schemes", wear_schemes.TITLE, wear_schemes.build),
    SectionPlan("paper", paper.TITLE, paper.build),
    SectionPlan("closed_forms", closed_forms.TITLE, closed_forms.build),
    SectionPlan("finite_elements", finite_elements.TITLE, finite_elements.build),
    SectionPlan("helical_pairs", helical_pairs.TITLE, helical_pairs.build),
    SectionPlan("failure_modes", failure_modes.TITLE, failure_modes.build),
    SectionPlan("peers", peers.TITLE, peers.build),
    SectionPlan("hard_cases", hard_cases.TITLE, hard_cases.build),
)
