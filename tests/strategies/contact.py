"""Surfaces for half-space contact: smooth and rough, on cells of any aspect."""

from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st

from semiwear.closed_forms.love import love_coefficients


@dataclass(frozen=True)
class Surface:
    """A gap [mm] on a grid, with a modulus [MPa] and a load [N] that presses part of it."""

    gap: np.ndarray
    cell: tuple[float, float]
    modulus: float
    load: float


def compliance_matrix(shape: tuple[int, int], cell: tuple[float, float], modulus: float) -> np.ndarray:
    """Displacement of every cell under unit pressure on every other, cell by cell [mm/MPa]."""
    coefficients = love_coefficients(shape, cell) / modulus
    i, j = (part.ravel() for part in np.indices(shape))
    return coefficients[np.abs(i[:, None] - i), np.abs(j[:, None] - j)]


def coordinates(shape: tuple[int, int], cell: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Cell centres from the middle of the grid [mm], to be broadcast."""
    x, y = ((np.arange(n) - (n - 1) / 2) * side for n, side in zip(shape, cell, strict=True))
    return x[:, None], y[None, :]


@st.composite
def surfaces(draw: st.DrawFn, most: int = 24) -> Surface:
    """A tilted paraboloid with waves and noise, up to `most` cells a side."""
    shape = draw(st.integers(1, most)), draw(st.integers(2, most))
    cell = draw(st.sampled_from([0.01, 0.1, 1.0])), draw(st.sampled_from([0.01, 0.13, 2.0]))
    modulus = draw(st.sampled_from([1.0, 7e4, 1.15e5]))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    x, y = coordinates(shape, cell)
    x, y = x / (shape[0] * cell[0]), y / (shape[1] * cell[1])
    noise = draw(st.sampled_from([0.0, 0.01, 0.3]))
    gap = x**2 + draw(st.floats(0.2, 2.0)) * y**2 + draw(st.floats(-0.5, 0.5)) * x + noise * random.random(shape)
    height = draw(st.sampled_from([1e-4, 1e-2]))
    area = shape[0] * shape[1] * cell[0] * cell[1]
    load = draw(st.sampled_from([1e-3, 0.03, 0.3])) * modulus * height / np.sqrt(area) * area
    return Surface(gap * height, cell, modulus, float(load))
