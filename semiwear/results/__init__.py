"""Results: the schema of their variables, labelled datasets, files and provenance."""

from __future__ import annotations

from semiwear.results.datasets import build_dataset, build_tree, check_tree
from semiwear.results.files import open_results, save
from semiwear.results.provenance import provenance
from semiwear.results.schema import COORDINATES, GROUPS, SCHEMA_VERSION, VARIABLES, Variable, Zone

__all__ = [
    "COORDINATES",
    "GROUPS",
    "SCHEMA_VERSION",
    "VARIABLES",
    "Variable",
    "Zone",
    "build_dataset",
    "build_tree",
    "check_tree",
    "open_results",
    "provenance",
    "save",
]
