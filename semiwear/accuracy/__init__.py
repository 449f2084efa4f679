"""A result as accurate as asked for, which tells its own error."""

from semiwear.accuracy.run import simulate

__all__ = ["simulate"]
