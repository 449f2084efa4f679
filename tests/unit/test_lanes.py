"""Transforms without vectors, as with a numba that no longer has the parts that these are made of."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from semiwear.compliance.half_space import HalfSpace

SHAPES = [(32, 40), (97, 30), (5, 5)]
CODE = """
import json, sys, warnings
if sys.argv[1] == "without":
    sys.modules["semiwear.compliance.vector_lanes"] = None
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    from semiwear.compliance import lanes
from semiwear.compliance.half_space import HalfSpace
import numpy as np
moved = []
for shape in json.loads(sys.argv[2]):
    pressure = np.random.default_rng(1).random(shape)
    moved.append(HalfSpace(tuple(shape), (0.1, 0.3)).apply(pressure).tolist())
print(json.dumps([lanes.lane_count(float), [str(w.message) for w in told], moved]))
"""


@pytest.mark.slow
def test_single_numbers_do_what_vectors_do(tmp_path):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    arguments = [sys.executable, "-c", CODE, "without", json.dumps(SHAPES)]
    answer = subprocess.run(arguments, env=environment, capture_output=True, text=True, check=True)
    lanes, told, moved = json.loads(answer.stdout)
    assert lanes == 1
    assert (
        len(told) == 1 and "does not take semiwear's vectors" in told[0] and "four to eight times slower" in told[0]
    )
    assert (tmp_path / "single-numbers").is_dir()
    for shape, found in zip(SHAPES, moved, strict=True):
        usual = HalfSpace(shape, (0.1, 0.3)).apply(np.random.default_rng(1).random(shape))
        np.testing.assert_allclose(found, usual, rtol=1e-13)


def test_this_numba_takes_vectors():
    """A warning of the import would be an error here; without vectors, nothing else would say it."""
    from semiwear.compliance import lanes

    assert lanes.VECTORISED and lanes.lane_count(np.float32) == 2 * lanes.lane_count(np.float64) == 8
