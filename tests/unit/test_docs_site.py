"""Pages of the documentation site: complete against the declarations, linked, and found without an edit elsewhere."""

import ast
import re
from pathlib import Path

import pytest
from site_pages.api import PACKAGES, public_names
from site_pages.command_line import commands
from site_pages.extras import FOR_DEVELOPERS, FOR_USERS, extras_tables, optional_dependencies
from site_pages.more import more_page
from site_pages.pages import reference_pages

import semiwear as sw
from semiwear.cli import _parser
from semiwear.results import COORDINATES, VARIABLES
from semiwear.scene import EFFECTS
from semiwear.scene.guide import field_notes
from semiwear.scene.schema import SCHEMAS

ROOT = Path(sw.__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted([*DOCS.glob("*.md"), *DOCS.glob("[!g]*/*.md"), *DOCS.glob("get_started/*.md"), ROOT / "README.md"])
SCRIPTS = sorted([*DOCS.glob("gallery/*.py"), *DOCS.glob("tutorials/*.py")])
FEWEST_EXAMPLES, TUTORIALS = 15, 5


@pytest.fixture(scope="module")
def reference() -> dict[str, str]:
    return reference_pages()


@pytest.mark.parametrize("kind", SCHEMAS)
def test_every_field_stands_on_its_page_with_unit_default_and_range(kind: str, reference: dict[str, str]) -> None:
    entries = set(reference["fields_all.md"].splitlines()) | set(reference[f"fields_{kind}.md"].splitlines())
    for note in field_notes(kind):
        table, _, name = note.key.rpartition(".")
        heads = [entry for entry in entries if entry.startswith(f"`{name}`")]
        assert heads, note.key
        assert note.unit == "1" or any(f"· {note.unit} ·" in head for head in heads), note.key
        assert f": {note.meaning} Allowed: {note.allowed}." in entries, note.key
        assert not table or f"## `[{table}]`" in entries, note.key


def test_a_default_that_follows_is_told_for_the_shipped_scene(reference: dict[str, str]) -> None:
    assert "follows from `module_mm`, `pinion_teeth` (`50` in `face_gear_25x160`)" in reference["fields_face_gear.md"]


def test_every_variable_stands_on_the_page_with_unit_and_source(reference: dict[str, str]) -> None:
    page = reference["variables.md"]
    for entry in [*COORDINATES.values(), *VARIABLES.values()]:
        group = page.partition(f"## `/{entry.group}`" if entry.group else "## Coordinates")[2].partition("\n## ")[0]
        head, _, rest = group.partition(f"\n`{entry.name}` ")[2].partition("\n")
        assert head.endswith(entry.units if entry.units != "1" else "pure number or text"), entry.path
        said = rest.partition("\n\n")[0].rstrip()
        assert entry.long_name[1:] in said and said.endswith(f"Source: {entry.references}."), entry.path
        assert all(f"`{key}`" in said for key in entry.needs), entry.path


def test_every_effect_command_and_public_name_has_its_place(reference: dict[str, str]) -> None:
    for name, table in EFFECTS.items():
        section = reference["effects.md"].partition(f"## `[effects.{name}]`")[2].partition("\n## ")[0]
        assert table.validity in section and all(source in section for source in table.references)
    parsers = commands(_parser())
    assert {"run", "plan", "sweep"} <= set(parsers)
    for name, parser in parsers.items():
        assert f"## semiwear {name}" in reference["command_line.md"]
        assert parser.format_help().rstrip() in reference["command_line.md"]
    listed = {
        line.strip() for name, text in reference.items() if name.startswith("api") for line in text.splitlines()
    }
    for package in ("semiwear", *PACKAGES):
        assert set(public_names(package)) <= listed, package


def test_every_extra_is_told_with_what_it_brings() -> None:
    needs, told = optional_dependencies(ROOT), FOR_USERS | FOR_DEVELOPERS
    assert set(told) == set(needs)
    for extra, sentence in told.items():
        (row,) = (line for line in extras_tables(ROOT).splitlines() if line.startswith(f"| `{extra}` | {sentence} |"))
        for requirement in needs[extra]:
            name, _, extras = re.split(r"[><=\]]", requirement)[0].partition("[")
            wanted = [f"`{part}`" for part in extras.split(",")] if extras else [name]
            assert all(one in row for one in wanted), (extra, requirement)
    page = (DOCS / "get_started" / "install.md").read_text(encoding="utf-8")
    assert "generated/extras.md" in page


def test_the_table_of_a_drawing_names_fields() -> None:
    text = (DOCS / "how_to" / "drawing.md").read_text(encoding="utf-8")
    known = {note.key.rpartition(".")[2] for kind in SCHEMAS for note in field_notes(kind)}
    rows = [line for line in text.splitlines() if line.startswith("|")]
    named = {name.rpartition(".")[2] for row in rows for name in re.findall(r"`([a-zA-Z_.0-9]+)`", row)}
    tables = {"gear_pair", "gear", "misalignment", "ISO"}
    assert {"normal_module_mm", "helix_angle_deg", "pinion_profile_shift", "centre_distance_mm"} <= named
    assert not {name for name in named - tables if name not in known}


def test_a_page_in_no_list_is_found(tmp_path: Path) -> None:
    (tmp_path / "how_to").mkdir()
    (tmp_path / "how_to" / "index.md").write_text("# How\n\n```{toctree}\n/old\n```\n", encoding="utf-8")
    for name in ("index", "old"):
        (tmp_path / f"{name}.md").write_text(f"# {name}\n", encoding="utf-8")
    assert "orphan" in more_page(tmp_path)
    (tmp_path / "new.md").write_text("# New\n", encoding="utf-8")
    assert "/new\n" in more_page(tmp_path) and "/old" not in more_page(tmp_path)


def written_by_the_build(target: str) -> bool:
    """Whether the build writes a page; those of the gallery carry the names of their scripts."""
    if "generated/reference/" in target:
        return (
            f"{target.rpartition('/')[2]}" in reference_pages()
            or f"{target.rpartition('/')[2]}.md" in reference_pages()
        )
    return target.rpartition("/")[2].removesuffix(".html") in {
        "index",
        "validated.md",
        "more",
        *(s.stem for s in SCRIPTS),
    }


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    text = re.sub(r"```(?!\{).*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    targets = re.findall(r"\]\(([^)\s]+)\)", text) + re.findall(r"\{(?:doc|download)\}`[^`]*<([^>`]+)>`", text)
    for target in targets:
        path, _, anchor = target.partition("#")
        if path.startswith(("http:", "https:", "mailto:")):
            continue
        file = (DOCS / path.lstrip("/")) if path.startswith("/") else (page.parent / path if path else page)
        if "generated/" in path:
            assert written_by_the_build(path), f"{page.name}: {target}"
            continue
        found = next((one for one in (file, file.with_name(f"{file.name}.md")) if one.is_file()), None)
        assert found or file.is_dir(), f"{page.name}: {target}"
        if anchor and found:
            titles = re.findall(r"(?m)^#+ (.+)$", found.read_text(encoding="utf-8"))
            slugs = {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}
            assert anchor in slugs, f"{page.name}: {target}"


def test_scripts_of_the_gallery_are_many_and_have_titles() -> None:
    assert len([s for s in SCRIPTS if s.parent.name == "gallery"]) >= FEWEST_EXAMPLES
    assert len([s for s in SCRIPTS if s.parent.name == "tutorials"]) >= TUTORIALS
    for script in SCRIPTS:
        title, _, rest = (ast.get_docstring(ast.parse(script.read_text(encoding="utf-8"))) or "").partition("\n")
        assert title and rest.startswith("=" * len(title)), script.name
