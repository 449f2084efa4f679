"""Pages that stand in no list of contents yet, so that a new one is found without an edit elsewhere."""

from __future__ import annotations

import re
from fnmatch import fnmatch
from pathlib import Path


def more_page(here: Path) -> str:
    """A page that lists them."""
    listed = {"index"}
    for page in here.glob("**/*.md"):
        if "generated" in page.parts:
            continue
        for block in re.findall(r"```\{toctree\}\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            entries = [line.strip() for line in block.splitlines() if line.strip() and not line.startswith(":")]
            listed |= {re.sub(r".*<(.*)>", r"\1", entry).lstrip("/").removeprefix("../") for entry in entries}
    rest = sorted(page.stem for page in here.glob("*.md") if not any(fnmatch(page.stem, one) for one in listed))
    if not rest:
        return "---\norphan: true\n---\n\n# More\n\nEvery page is in a section of its own.\n"
    return "\n".join(["# More", "", "```{toctree}", *(f"/{name}" for name in rest), "```", ""])
