"""Settings of the gallery and of the theme."""

from __future__ import annotations

from pathlib import Path
from typing import Any

THEME: dict[str, Any] = {
    "logo": {"text": "semiwear"},
    "navbar_align": "left",
    "header_links_before_dropdown": 6,
    "navigation_with_keys": False,
    "show_prev_next": True,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}


def gallery(here: Path) -> dict[str, Any]:
    """Every script is executed; one that fails stops the build."""
    return {
        "examples_dirs": [str(here / "tutorials"), str(here / "gallery")],
        "gallery_dirs": ["generated/tutorials", "generated/gallery"],
        "backreferences_dir": "generated/backreferences",
        "doc_module": ("semiwear",),
        "filename_pattern": r"\.py$",
        "ignore_pattern": r"__init__\.py",
        "within_subsection_order": "FileNameSortKey",
        "abort_on_example_error": True,
        "parallel": 2,
        "default_thumb_file": str(here / "worn_face_gear.png"),
        "download_all_examples": False,
        "show_signature": False,
        "min_reported_time": 1e9,
        "write_computation_times": False,
        "remove_config_comments": True,
        "matplotlib_animations": False,
        "image_scrapers": ("matplotlib",),
        "reset_modules": ("matplotlib",),
        "plot_gallery": "True",
        "capture_repr": (),  # what is shown is printed or drawn
    }
