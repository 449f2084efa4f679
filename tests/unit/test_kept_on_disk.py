"""Results that are kept in files: told apart by arguments, never wrong, never in the way."""

import os
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import semiwear as sw
from semiwear import kept_on_disk as module
from semiwear.kept_on_disk import kept_on_disk
from semiwear.plan import teeth
from tests.scenes import TINY

CALLS: list[float] = []


@dataclass(frozen=True)
class Body:
    """Something with an array."""

    outline: np.ndarray
    name: str = "tooth"
    rim: float | None = None


@kept_on_disk
def doubled(bodies: tuple[Body, ...], *, factor: float = 2.0) -> tuple[np.ndarray, ...]:
    """Outlines times a factor; calls are noted."""
    CALLS.append(factor)
    return tuple(factor * body.outline for body in bodies)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of each test's own."""
    monkeypatch.setenv("SEMIWEAR_CACHE_DIR", str(tmp_path / "kept"))
    CALLS.clear()
    return tmp_path / "kept"


BODY = Body(np.linspace(0.0, 1.0, 7))


def test_equal_arguments_are_read_again() -> None:
    """Also where the same array stands in two places instead of one: it is the values that count."""
    first = doubled((BODY, BODY))
    again = doubled((BODY, Body(BODY.outline.copy())))
    assert len(CALLS) == 1
    for one, other in zip(first, again, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    "other",
    [
        replace(BODY, name="gear"),
        replace(BODY, rim=0.0),
        replace(BODY, outline=BODY.outline + 1e-15),
        replace(BODY, outline=BODY.outline[:, None]),
        replace(BODY, outline=BODY.outline.astype(np.float32)),
    ],
)
def test_whatever_differs_is_computed(other: Body) -> None:
    """Any field, the last bit, the shape, the type."""
    doubled((BODY,))
    doubled((other,))
    assert len(CALLS) == 2


def test_keywords_count() -> None:
    """And so does the number of things."""
    doubled((BODY,))
    doubled((BODY,), factor=3.0)
    doubled((BODY, BODY))
    assert len(CALLS) == 3


def test_what_cannot_be_told_apart_is_an_error() -> None:
    """Instead of a result that belongs to another call."""
    with pytest.raises(TypeError, match="list"):
        doubled([BODY])  # type: ignore[arg-type]


def test_damaged_file_is_computed_anew(folder: Path) -> None:
    """Cut short, and other bytes altogether; it is mended by that."""
    good = doubled((BODY,))
    (file,) = folder.iterdir()
    whole = file.read_bytes()
    for bad in (whole[:20], b"", b"no pickle"):
        file.write_bytes(bad)
        np.testing.assert_array_equal(doubled((BODY,))[0], good[0])
        assert file.read_bytes() == whole
    assert len(CALLS) == 4


def test_off_keeps_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No folder is made."""
    monkeypatch.setenv("SEMIWEAR_CACHE_DIR", "off")
    doubled((BODY,))
    doubled((BODY,))
    assert len(CALLS) == 2 and not folder.exists()


@pytest.mark.skipif(os.name == "nt", reason="rights of other users")
def test_folder_of_others_is_not_used(folder: Path) -> None:
    """Files are read as Python objects: who can write them can run code."""
    folder.mkdir()
    folder.chmod(0o777)
    doubled((BODY,))
    assert not any(folder.iterdir())


def test_no_folder_can_be_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file stands in its place: results come all the same."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("SEMIWEAR_CACHE_DIR", str(tmp_path / "file" / "kept"))
    np.testing.assert_array_equal(doubled((BODY,))[0], 2.0 * BODY.outline)


def test_longest_unused_go_first(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was read lately stays."""
    doubled((BODY,), factor=1.0)
    (first,) = folder.iterdir()
    monkeypatch.setattr(module, "_MOST_BYTES", 2 * first.stat().st_size + 1)
    os.utime(first, (0.0, 0.0))
    doubled((BODY,), factor=2.0)
    (second,) = set(folder.iterdir()) - {first}
    os.utime(second, (1.0, 1.0))  # clocks of files may tick more slowly than this test runs
    doubled((BODY,), factor=1.0)
    doubled((BODY,), factor=3.0)
    assert CALLS == [1.0, 2.0, 3.0] and len(list(folder.iterdir())) == 2
    doubled((BODY,), factor=1.0)
    assert CALLS == [1.0, 2.0, 3.0]


@pytest.mark.slow
def test_teeth_are_the_same_to_the_bit(folder: Path) -> None:
    """Computed and read: helical teeth with their ends and wheels."""
    scene = sw.load_scene("spur_fzg_c").replace(
        TINY | {"gear_pair.helix_angle_deg": 20.0, "gear_pair.centre_distance_mm": None}
    )

    def matrix() -> np.ndarray:
        for kept in (teeth.prisms, teeth.toothed, teeth.free_ends, teeth.wheel_under):
            kept.cache_clear()
        for kept in (teeth._prisms_on_lines, teeth._known_compliance):
            kept.cache_clear()
        return sw.plan(scene).loaded_teeth().problem.candidates(0, 0.0).smooth

    computed = matrix()
    files = set(folder.iterdir())
    np.testing.assert_array_equal(matrix(), computed)
    assert files and set(folder.iterdir()) == files
