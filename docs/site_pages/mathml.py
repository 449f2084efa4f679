"""Formulas as MathML, which browsers draw by themselves: nothing is fetched and no script runs."""

from __future__ import annotations

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer; ``html_math_renderer = "mathml"`` chooses it."""
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _inline(writer: nodes.NodeVisitor, node: nodes.math) -> None:
    writer.body.append(convert(node.astext(), display="inline"))
    raise nodes.SkipNode


def _display(writer: nodes.NodeVisitor, node: nodes.math_block) -> None:
    formula = convert(_lines(node.astext()), display="block")
    writer.body.append(f'<div class="formula">{formula}</div>\n')
    raise nodes.SkipNode


def _lines(latex: str) -> str:
    """LaTeX of a display; lines of their own become an aligned block."""
    return latex if r"\\" not in latex or r"\begin" in latex else rf"\begin{{aligned}}{latex}\end{{aligned}}"
