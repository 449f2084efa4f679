"""Measured flanks: registration, deviations, wear, and calibration of the wear coefficient.

>>> deviations = sw.register(scene, "tooth_7.nc")                  # um along the normals, and the datum
>>> found = sw.calibrate(scene, "worn.nc", before="new.nc", meshes=4e7)
>>> print(found)                                                    # k with its confidence interval
>>> print(found.life(60.0))                                         # B10, median, B90
>>> sw.plot.measured_wear(found.comparison())
"""

from semiwear.measured.calibration import Calibration, calibrate
from semiwear.measured.comparison import compare_wear
from semiwear.measured.life_spread import LifeSpread
from semiwear.measured.point_cloud import flank_from_points
from semiwear.measured.registration import register
from semiwear.measured.trace_files import read_traces
from semiwear.measured.traces import Trace, TracedFlank, flank_from_traces
from semiwear.measured.worn import measured_wear

__all__ = [
    "Calibration",
    "LifeSpread",
    "Trace",
    "TracedFlank",
    "calibrate",
    "compare_wear",
    "flank_from_points",
    "flank_from_traces",
    "measured_wear",
    "read_traces",
    "register",
]
