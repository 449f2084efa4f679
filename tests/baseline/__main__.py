"""Renew stored results: ``python -m tests.baseline NAME ...``, or ``all``; without names, list them."""

import argparse

from tests.baseline.digest import differences, digest
from tests.baseline.scenes import RUNS, result
from tests.baseline.stored import read, write


def main() -> None:
    """Compute the runs that are named, say what changes, and keep them."""
    parser = argparse.ArgumentParser(prog="python -m tests.baseline", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="runs to renew, or all")
    names = parser.parse_args().names
    if not names:
        print("\n".join(RUNS))
        return
    unknown = sorted(set(names) - set(RUNS) - {"all"})
    if unknown:
        parser.error(f"no run is called {', '.join(unknown)}; they are: {'; '.join(RUNS)}")
    for name in RUNS if names == ["all"] else names:
        found = digest(result(name))
        try:
            lines = differences(found, read(name))
        except FileNotFoundError:
            lines = ["new"]
        write(name, found)
        print(f"{name}: {'as before' if not lines else ''}", *lines, sep="\n  " if lines else "")


if __name__ == "__main__":
    main()
