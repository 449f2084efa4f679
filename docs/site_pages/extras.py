"""Tables of what can be installed besides, from ``pyproject.toml`` and a sentence for each."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

FOR_USERS = {
    "plot": "Pictures of flanks and histories, and the report with pictures that stand still.",
    "report": "The report with a tooth that can be turned.",
    "progress": "A progress bar.",
    "loads": "A load spectrum of a measured torque, by rainflow counting.",
    "sweep": "Studies on a Dask cluster, and their datasets as `.zarr` folders.",
    "infer": "Inference of wear coefficient, torque and misalignment from worn flanks; emulators.",
    "view": "Worn flanks and teeth as surfaces for ParaView, PyVista and CAD.",
    "tables": "Results as workbooks of spreadsheets.",
    "completion": "Commands completed by the shell.",
    "rotors": "Models of shafts in ROSS that take the mesh stiffness of a worn pair.",
    "fem": "A faster solver for finite-element root stress.",
    "all": "All of these but `rotors`.",
}
FOR_DEVELOPERS = {
    "test": "The tests, the linters and the type checker.",
    "docs": "This site.",
    "notebook": "The notebook as a test.",
    "bench": "Times over the history of the sources.",
    "peers": "Other codes that the half-space contact is compared with.",
}


def optional_dependencies(root: Path) -> dict[str, list[str]]:
    """Extras of the project with what each installs."""
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return dict(project["optional-dependencies"])


def extras_tables(root: Path) -> str:
    """What users may install, and what developers may."""
    needs = optional_dependencies(root)
    lines: list[str] = []
    for told in (FOR_USERS, FOR_DEVELOPERS):
        if lines:
            lines += ["", "And for work on semiwear itself:", ""]
        lines += ["| extra | for | brings |", "|---|---|---|"]
        lines += [f"| `{extra}` | {sentence} | {_brings(needs[extra])} |" for extra, sentence in told.items()]
    return "\n".join(lines) + "\n"


def _brings(requirements: list[str]) -> str:
    names: list[str] = []
    for requirement in requirements:
        name, extras = re.match(r"([A-Za-z0-9_-]+)(?:\[(.*)\])?", requirement).groups()  # type: ignore[union-attr]
        names += [f"`{extra}`" for extra in extras.split(",")] if extras else [name]
    return ", ".join(names)
