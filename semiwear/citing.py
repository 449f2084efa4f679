"""Sources of a run as BibTeX."""

from __future__ import annotations

from xarray import DataTree

from semiwear.errors import SemiwearError
from semiwear.plan import plan
from semiwear.references.citations import bibtex
from semiwear.results.provenance import version
from semiwear.scene import Scene


def citations(of: DataTree | Scene) -> str:
    """Sources of the models and data that a run used, or that a scene would use, as BibTeX.

    Parameters
    ----------
    of : DataTree or Scene
        A result, whose attribute `references` names them, or a scene.

    Raises
    ------
    SemiwearError
        The tree is no result of semiwear.
    """
    if isinstance(of, Scene):
        return bibtex(plan(of).references, version())
    if "references" not in of.attrs:
        raise SemiwearError("citations: the tree has no references, so it is no result of semiwear")
    return bibtex(filter(None, str(of.attrs["references"]).splitlines()), version())
