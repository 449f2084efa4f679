"""
Hertz's ellipse by the half-space solver
========================================

The solver behind fidelity ``patch`` takes any gap on a regular grid. Where Hertz knows the answer they agree.
"""

import matplotlib.pyplot as plt
import numpy as np

from semiwear.closed_forms import elliptic_contact
from semiwear.contact import solve_half_space

load, modulus, curvatures = 2000.0, 115e3, (1 / 20.0, 1 / 400.0)  # N, MPa, 1/mm
hertz = elliptic_contact(load, *curvatures, modulus)
print(hertz)

# %%
# A grid that is a little wider than the ellipse, both ways.
half = 1.3 * np.array([hertz.minor_half_axis, hertz.major_half_axis])
x, y = (np.linspace(-side, side, 129) for side in half)
gap = 0.5 * curvatures[0] * x[:, None] ** 2 + 0.5 * curvatures[1] * y**2
contact = solve_half_space(gap, cell=(x[1] - x[0], y[1] - y[0]), effective_modulus=modulus, load=load)

figure, ax = plt.subplots(layout="constrained")
ax.plot(x, contact.pressure[:, 64], ".", label="solved")
inside = np.clip(1.0 - (x / hertz.minor_half_axis) ** 2, 0.0, None)
ax.plot(x, hertz.peak_pressure * np.sqrt(inside), label="Hertz")
ax.set(xlabel="across the ellipse [mm]", ylabel="pressure [MPa]")
ax.legend()
print(f"peak pressure: {contact.pressure.max() / hertz.peak_pressure - 1:+.2%} of Hertz's")
