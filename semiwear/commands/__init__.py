"""Commands of the command line as functions of its options; each prints its end and gives it to machines."""

from semiwear.commands.exchange import export, new, report, rexs
from semiwear.commands.one_scene import calibrate, geometry, screen
from semiwear.commands.simulation import kept, run
from semiwear.commands.studies import infer, optimise, sweep

__all__ = [
    "calibrate",
    "export",
    "geometry",
    "infer",
    "kept",
    "new",
    "optimise",
    "report",
    "rexs",
    "run",
    "screen",
    "sweep",
]
