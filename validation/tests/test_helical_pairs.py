"""The stored finite-element results of helical pairs are of the scenes that would be computed now."""

import json

import numpy as np
import pytest

from semiwear.errors import ResultFileError
from validation import helical_pairs
from validation.helical_pairs import PAIRS, HelicalResult


def test_names_are_told_apart() -> None:
    assert len({pair.name for pair in PAIRS}) == len(PAIRS)


def test_stored_results_are_of_their_scenes() -> None:
    known = {pair.name: pair for pair in PAIRS}
    stored = helical_pairs.read()
    assert stored
    for name, result in stored.items():
        assert len(result.transmission_error) == len(result.load_share) == len(known[name].positions)
        assert np.all(np.array(result.transmission_error) < 0.0) and min(result.root_stress.values()) > 0.0


def test_a_result_of_another_scene_is_refused(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(helical_pairs, "DATA", tmp_path / "pairs.json")
    helical_pairs.store(PAIRS[0], HelicalResult([-1.0] * 4, {"pinion": 1.0, "gear": 1.0}, [0.5] * 4))
    assert list(helical_pairs.read()) == [PAIRS[0].name]
    kept = json.loads(helical_pairs.DATA.read_text())
    kept[PAIRS[0].name]["scene_toml"] += "# changed"
    helical_pairs.DATA.write_text(json.dumps(kept))
    with pytest.raises(ResultFileError, match=f"--recompute {PAIRS[0].name}"):
        helical_pairs.read()
