#!/usr/bin/env python3
# /// script
# dependencies = ["nox>=2024.10.9"]
# ///
"""Sessions: ``nox -s tests slow lint lowest docs bench``; ``nox`` alone runs the quick tests and the linters.

Each has an environment of its own; ``nox -R`` uses it again, and ``nox --no-venv`` uses what is installed where nox
runs, as ``.ci/run`` does. What follows ``--`` goes to the tool.
"""

from __future__ import annotations

import nox

nox.needs_version = ">=2024.10.9"
nox.options.default_venv_backend = "uv|virtualenv"
nox.options.reuse_existing_virtualenvs = True


def install(session: nox.Session, extra: str) -> None:
    """Install the project with an extra, unless the session runs in an environment that is there already."""
    if session.venv_backend != "none":
        session.install("-e", f".[{extra}]")


@nox.session
def tests(session: nox.Session) -> None:
    """Run the quick tests, which cover every module."""
    install(session, "test")
    session.run("python", "-m", "pytest", *session.posargs)


@nox.session(default=False)
def slow(session: nox.Session) -> None:
    """Run finite elements, doubled grids and whole lives."""
    install(session, "test")
    session.run("python", "-m", "pytest", "-m", "slow", *session.posargs)


@nox.session
def lint(session: nox.Session) -> None:
    """Lint, check the format and the types."""
    install(session, "test")
    session.run("ruff", "check", ".")
    session.run("ruff", "format", "--check", ".")
    session.run("mypy")


@nox.session(default=False, venv_backend="none")
def lowest(session: nox.Session) -> None:
    """Run the lowest versions that are allowed, in an environment that is made for it."""
    session.run(".ci/lowest", external=True)


@nox.session(default=False)
def docs(session: nox.Session) -> None:
    """Build the documentation site into the folder `site`; a warning is an error."""
    install(session, "docs")
    session.run("sphinx-build", "-W", "docs", "site", *session.posargs)


@nox.session(default=False)
def bench(session: nox.Session) -> None:
    """Time the main cases; ``-- --against COMMIT`` compares with a stored version in pairs."""
    install(session, "plot")
    session.run("python", "validation/bench_main.py", *session.posargs)


if __name__ == "__main__":
    nox.main()
