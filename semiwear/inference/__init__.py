"""Inference of unknown fields of a scene from worn flanks, measured wear and transmission error."""

from __future__ import annotations

from semiwear.inference.observations import Observation, Reading, TransmissionErrorCurve, WearAtPoints, WornFlank
from semiwear.inference.posterior import Posterior
from semiwear.inference.run import infer

__all__ = ["Observation", "Posterior", "Reading", "TransmissionErrorCurve", "WearAtPoints", "WornFlank", "infer"]
