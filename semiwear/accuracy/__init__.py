"""Results to a requested accuracy, with an estimate of their error."""

from semiwear.accuracy.run import simulate

__all__ = ["simulate"]
