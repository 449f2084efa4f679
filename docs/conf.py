"""Settings of the documentation site: ``python -m sphinx -W docs site`` (extra ``docs``).

Everything that is written while it builds goes to ``docs/generated`` and ``site``, which git ignores.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent
sys.path[:0] = [str(HERE), str(ROOT)]
# dense matrices are small here: threads of BLAS wait for each other
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MPLBACKEND", "agg")
# commands shown on pages are those of this environment, 100 columns wide
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
os.environ["COLUMNS"] = "100"

from site_pages import pages, settings  # noqa: E402

import semiwear  # noqa: E402

project = "semiwear"
author = "The semiwear developers"
copyright = author
version = release = semiwear.__version__

extensions = [
    "matplotlib.sphinxext.plot_directive",
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "site_pages.mathml",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "sphinxcontrib.programoutput",
]
root_doc = "index"
exclude_patterns = [
    "site_pages",
    "generated/work",
    "generated/validated.md",
    "generated/extras.md",
    "**/GALLERY_HEADER.rst",
    "gallery",
    "**.ipynb",
    "tutorials/*.py",
]
default_role = "code"
nitpicky = False
suppress_warnings = ["config.cache", "misc.highlighting_failure", "myst.header", "toc.empty_glob"]

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath", "substitution"]
myst_heading_anchors = 3

autosummary_generate = True
autodoc_typehints = "none"  # numpydoc's sections name the types
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

plot_html_show_source_link = False
plot_html_show_formats = False
plot_formats = [("png", 120)]
plot_working_directory = str(HERE / "get_started")
plot_include_source = True

sphinx_gallery_conf = settings.gallery(HERE)
html_math_renderer = "mathml"

html_theme = "pydata_sphinx_theme"
html_title = f"semiwear {version}"
templates_path = ["_templates"]
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_theme_options = settings.THEME
html_sidebars = {"extending": [], "generated/more": [], "glossary": [], "whats_new": []}
html_copy_source = False
html_show_sourcelink = False


def setup(app: object) -> None:
    """Write the generated pages before Sphinx looks for its sources."""
    pages.write_all(HERE)
