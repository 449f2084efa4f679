"""No kernel of a run is compiled for two types of one thing: each would be waited for in a first run."""

from __future__ import annotations

import subprocess
import sys

RUN = """
import sys
from numba.core.registry import CPUDispatcher
import semiwear as sw
from semiwear.commands.late_kernels import compile_late_kernels
from tests.scenes import TINY, scene_of

compile_late_kernels()  # must be the very ones of a run
worn = {"wear.until.control_depths_um": (6.0, 12.0), "numerics.threads": 1}
for changes in ({}, {"wear.worn_bodies": ("pinion", "gear")}):
    sw.simulate(scene_of(TINY, worn, changes, wears=True))
rooms = [module for name, module in sys.modules.items() if name.startswith("semiwear.")]
for module in rooms:
    for name, kernel in vars(module).items():
        if isinstance(kernel, CPUDispatcher) and kernel.py_func.__module__ == module.__name__:
            if len(kernel.signatures) > 1:
                print(f"{module.__name__}.{name}: {kernel.signatures}")
"""


def test_every_kernel_is_compiled_once():
    done = subprocess.run([sys.executable, "-c", RUN], capture_output=True, text=True, check=True)
    assert done.stdout == ""
