"""A first run says that it compiles, once; a run that finds its kernels does not."""

from semiwear.commands.progress_bar import ProgressBar
from semiwear.console import notes_on_standard_error
from semiwear.kernel_cache import njit, on_first_compilation


def kernels():
    """Two kernels that were never compiled; they are kept nowhere."""
    return njit(lambda x: x + 1.0), njit(lambda x: x + 2.0)


def test_compiling_is_told_once():
    told: list[str] = []
    one, other = kernels()
    with on_first_compilation(lambda: told.append("compiles")):
        assert not told
        assert (one(1.0), other(1.0)) == (2.0, 3.0)
    assert told == ["compiles"]


def test_kernels_that_are_there_are_not_told():
    told: list[str] = []
    one, other = kernels()
    one(1.0)
    with on_first_compilation(lambda: told.append("compiles")):
        one(1.0)
    other(1.0)  # outside: nobody is told
    assert told == []


def test_a_command_tells_it_on_standard_error(capsys):
    for quiet, lines in ((False, 1), (True, 0)):
        with notes_on_standard_error(quiet), ProgressBar("begins ..."):
            for kernel in kernels():
                kernel(1.0)
        assert capsys.readouterr().err.count("compiling") == lines
