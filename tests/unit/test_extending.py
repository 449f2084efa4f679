"""What docs/extending.md says: the path of a run, and examples that are applied to a copy of the package."""

import importlib
import inspect
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import semiwear as sw
from semiwear.meshing.tooth_contact import separation_of_neighbours
from tests.scenes import TINY

PAGE = Path(__file__).parents[2] / "docs" / "extending.md"
PACKAGE = Path(sw.__file__).parent
MOST_FILES = {"A law of the wear coefficient": 2, "An effect on the gap": 3, "A kind of tooth": 4}
HEAD = re.compile(r'# (?P<file>\S+\.py), (?P<how>a new file|(?P<where>after|before|instead of) "(?P<place>.*)")\n')


def sections():
    """Title and code blocks of every example."""
    parts = re.split(r"(?m)^## (.+)$", PAGE.read_text(encoding="utf-8"))
    return {
        title: re.findall(r"```python\n(.*?)```", body, re.DOTALL)
        for title, body in zip(parts[1::2], parts[2::2], strict=True)
    }


def applied(block, root):
    """Make the change that a block describes; the file that it changes."""
    head = HEAD.match(block)
    assert head, f"a block that says neither where it goes nor that it is to be run:\n{block[:200]}"
    file, code = root / head["file"], block[head.end() :]
    if head["where"] is None:
        assert not file.exists()
        file.write_text(code, encoding="utf-8")
        return file
    text, place = file.read_text(encoding="utf-8"), head["place"].replace('\\"', '"')
    found = [line for line in text.splitlines(keepends=True) if line.startswith(place)]
    assert len(found) == 1, f"{head['file']}: {len(found)} lines begin with {place!r}"
    new = {"after": found[0] + code, "before": code + found[0], "instead of": code}[head["where"]]
    file.write_text(text.replace(found[0], new), encoding="utf-8")
    return file


def stops_of_a_run():
    """Name and what is given, of every stop of the page's table."""
    return re.findall(r"(?m)^\| `([a-z_.A-Z]+)` \| `([^`]+)`", PAGE.read_text(encoding="utf-8"))


def stop_at(name):
    """The module and the object of a stop."""
    parts = name.split(".")
    files = [k for k in range(2, len(parts)) if (PACKAGE / "/".join(parts[:k])).with_suffix(".py").is_file()]
    count = max(files, default=1)
    module = importlib.import_module(".".join(["semiwear", *parts[:count]]))
    found = module
    for part in parts[count:]:
        found = getattr(found, part)
    return module.__name__, found


def test_the_path_of_a_run_is_as_told():
    stops = [(*stop_at(name), given) for name, given in stops_of_a_run()]
    assert 10 <= len(stops) <= 14
    modules = [module for module, _, _ in stops]
    assert len(set(modules)) == len(modules)  # none is visited twice
    known = {"Scene"}
    for _, stop, given in stops:
        # what a stop takes from the run has been given by then
        taken = {entry.annotation for name, entry in inspect.signature(stop).parameters.items() if name != "self"}
        ours = {gives for _, _, gives in stops} - {"FloatArray"}
        known.add(given)  # a step goes on from what it gave before
        assert taken & ours <= known, stop
        assert given in (stop.__name__, inspect.signature(stop).return_annotation), stop


def test_a_run_takes_the_path(shipped):
    wanted = {stop.__qualname__ if inspect.isfunction(stop) else f"{stop.__qualname__}.__init__": name
              for name, _ in stops_of_a_run() for _, stop in [stop_at(name)]}  # fmt: skip
    seen = set()

    def watch(frame, event, _):
        if event == "call" and frame.f_globals.get("__name__", "").startswith("semiwear."):
            seen.add(frame.f_code.co_qualname)

    scene = shipped.replace({**TINY, "wear.until.control_depths_um": [5.0]})
    separation_of_neighbours.cache_clear()
    sys.setprofile(watch)
    try:
        sw.simulate(scene)
    finally:
        sys.setprofile(None)
    made = {name for name in wanted if name.endswith(".__init__")}  # by dataclasses, in no module
    assert set(wanted) - made <= seen


def test_examples_touch_few_files():
    for title, blocks in sections().items():
        files = {head["file"] for block in blocks if (head := HEAD.match(block))}
        assert 0 < len(files) <= MOST_FILES[title]
    assert set(sections()) == set(MOST_FILES)


@pytest.mark.slow
def test_examples_run(tmp_path):
    # with compiled kernels: those of files that an example changes are compiled anew
    shutil.copytree(PACKAGE, tmp_path / "semiwear", ignore=shutil.ignore_patterns("*.pyc"))
    lines = []
    for blocks in sections().values():
        for block in blocks:
            if block.startswith("# run\n"):
                lines.append(block)
            else:
                applied(block, tmp_path)
    script = tmp_path / "examples.py"
    script.write_text("\n".join(lines), encoding="utf-8")
    environment = os.environ | {"PYTHONPATH": str(tmp_path), "PYTHONWARNINGS": "error::RuntimeWarning"}
    done = subprocess.run(
        [sys.executable, script],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "wear_law.speed" in done.stdout
