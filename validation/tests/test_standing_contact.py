"""Wear of a contact that stands still: where explicit steps lose their stability."""

from __future__ import annotations

import numpy as np
import pytest

from validation.standing_contact import EXPLICIT_LIMIT, roughness_after, strips

STRIPS = strips(60)


def test_the_limit_of_explicit_steps_is_twice_the_least_eigenvalue():
    assert pytest.approx(1.485, abs=1e-3) == EXPLICIT_LIMIT
    assert 2.0 * np.linalg.eigvalsh(STRIPS)[0] == pytest.approx(EXPLICIT_LIMIT, rel=5e-3)


@pytest.mark.parametrize(("factor", "stable"), [(0.9, True), (0.97, True), (1.1, False), (1.5, False)])
def test_explicit_steps_lose_stability_at_the_limit(factor, stable):
    grown = roughness_after(factor * EXPLICIT_LIMIT, implicit=False)
    assert grown < 1.0 if stable else grown > 10.0


@pytest.mark.parametrize("factor", [0.9, 1.5, 10.0, 1e3, 1e6])
def test_implicit_steps_are_stable_however_long(factor):
    assert roughness_after(factor * EXPLICIT_LIMIT, implicit=True) < 1.0
