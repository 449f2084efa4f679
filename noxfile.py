#!/usr/bin/env python3
# /// script
# dependencies = ["nox>=2024.4"]
# ///
"""Sessions: ``nox -s tests slow lint docs bench``; ``nox`` alone runs the quick tests and the linters.

Each has an environment of its own; ``nox -R`` uses it again. What follows ``--`` goes to the tool.
"""

from __future__ import annotations

import nox

nox.needs_version = ">=2024.4"
nox.options.default_venv_backend = "uv|virtualenv"
nox.options.reuse_existing_virtualenvs = True


@nox.session
def tests(session: nox.Session) -> None:
    """Run the quick tests, which cover every module."""
    session.install("-e", ".[test]")
    session.run("pytest", *session.posargs)


@nox.session(default=False)
def slow(session: nox.Session) -> None:
    """Run finite elements, doubled grids and whole lives."""
    session.install("-e", ".[test]")
    session.run("pytest", "-m", "slow", *session.posargs)


@nox.session
def lint(session: nox.Session) -> None:
    """Lint, check the format and the types."""
    session.install("-e", ".[test]")
    session.run("ruff", "check", ".")
    session.run("ruff", "format", "--check", ".")
    session.run("mypy")


@nox.session(default=False)
def docs(session: nox.Session) -> None:
    """Build the documentation site into the folder `site`; a warning is an error."""
    session.install("-e", ".[docs]")
    session.run("sphinx-build", "-W", "docs", "site", *session.posargs)


@nox.session(default=False)
def bench(session: nox.Session) -> None:
    """Time the main cases; ``-- --against COMMIT`` compares with a stored version in pairs."""
    session.install("-e", ".[plot]")
    session.run("python", "validation/bench_main.py", *session.posargs)


if __name__ == "__main__":
    nox.main()
