"""Reports: one self-contained HTML page from a result (extra ``plot``)."""

from __future__ import annotations

from semiwear.report.page import write_report

__all__ = ["write_report"]
