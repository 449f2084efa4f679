"""Stored results of finite elements are of the scene that ships, or refused."""

from __future__ import annotations

from pathlib import Path

import pytest

import semiwear as sw
from semiwear.errors import ResultFileError
from validation import finite_elements as store


@pytest.mark.parametrize("case", store.stored())
def test_what_is_stored_is_of_the_shipped_scene(shipped: sw.Scene, case: str) -> None:
    scene = store.CONTACT[case].scene(shipped) if case in store.CONTACT else shipped
    tree = store.read(case, scene)
    assert tree.attrs["fidelity"] == "finite elements"
    assert float(tree.attrs["seconds"]) > 0.0
    assert store.path_of(case).stat().st_size < 400_000


def test_another_scene_is_refused(shipped: sw.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store, "DATA", tmp_path)
    other = shipped.replace({"numerics.face_slices": 21, "numerics.tooth_compliance": "rigid"})
    store.store("unworn", sw.loaded_contact(other, [0.0]), 1.0)
    with pytest.raises(ResultFileError, match="recompute unworn"):
        store.read("unworn", shipped)
    with pytest.raises(FileNotFoundError):
        store.read("worn", shipped)


def test_rows_compare_like_with_like(shipped: sw.Scene) -> None:
    """A result differs from itself by nothing, whatever the order of its mesh positions."""
    coarse = shipped.replace({"numerics.face_slices": 21, "numerics.tooth_compliance": "rigid"})
    once, again = sw.loaded_contact(coarse, [0.0, 0.4]), sw.loaded_contact(coarse, [0.4, 0.0])
    rows = store.contact_rows(once, again)
    assert {row.name for row in rows} >= {"load_share", "contact_pressure_max", "transmission_error_loaded, mean"}
    assert max(abs(row.difference) for row in rows) < 1e-9
    assert store.table(rows).count("\n") == len(rows)


@pytest.mark.slow
@pytest.mark.parametrize("fidelity", ["line", "patch"])
@pytest.mark.parametrize("case", ["unworn", "finer"])
def test_root_stress_of_every_pair_above_a_tenth_of_the_load_is_that_of_finite_elements(
    shipped: sw.Scene, case: str, fidelity: str
) -> None:
    """Found: the pinion at roll -0.78 was 8 % high, since loads beside its fillet stressed the root falsely.

    At `patch`, beside pressed tip edges of worn flanks, the gear was up to 10 % high: bent teeth leant away from the
    edges in elements alone.
    """
    rows = store.compare(case, shipped, fidelity)
    bears = {row.where for row in rows if row.name == "load_share" and row.reference > 0.1}
    compared = [row for row in rows if row.name.startswith("root_stress") and row.where in bears]
    assert len(compared) > 20
    # a load 3 % higher, 0.4 % of all: see docs/validation.md
    barely = [row for row in compared if (row.name, row.where) == ("root_stress pinion", "roll -0.778")]
    assert max(abs(row.difference) for row in compared if row not in barely) < 0.04, store.table(compared)
    assert max(abs(row.difference) for row in barely) < (0.053 if case == "finer" else 0.05), store.table(barely)
