"""Kernels for whose arrays numba counts no references: they must not make one, hand one back, or call what does."""

import ast
from collections.abc import Iterator

import numba.core.cpu
import numpy as np
import pytest
from numba.core.errors import NumbaError

from semiwear import kernel_cache
from semiwear.contact.position_solver import share_torque
from semiwear.contact.problem import picked
from semiwear.kernel_cache import inner_njit, njit
from tests.unit.test_architecture import MODULES, parsed


def trees() -> dict[str, ast.Module]:
    """Modules that may have kernels or tuples with names: the others need not be parsed."""
    texts = {name: path.read_text(encoding="utf-8") for name, path in MODULES.items()}
    return {name: parsed(MODULES[name]) for name, text in texts.items() if "njit" in text or "NamedTuple" in text}


def kernels(tree: ast.Module) -> dict[str, tuple[str, ast.FunctionDef]]:
    """Decorator and body of every kernel of a module."""
    found = {}
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            for how in node.decorator_list:
                if (kind := ast.unparse(how).split("(")[0]) in ("njit", "inner_njit"):
                    found[node.name] = kind, node
    return found


def named_tuples(tree: ast.Module) -> set[str]:
    """Tuples with names that hold arrays, of a module."""
    return {
        node.name
        for node in tree.body
        if isinstance(node, ast.ClassDef) and any("NamedTuple" in ast.unparse(base) for base in node.bases)
        if any("Array" in ast.unparse(entry.annotation) for entry in node.body if isinstance(entry, ast.AnnAssign))
    }


def names_of(tree: ast.Module) -> dict[str, tuple[str, str]]:
    """Module and name behind every name that a module imports from the package."""
    return {
        one.asname or one.name: (node.module.removeprefix("semiwear."), one.name)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("semiwear")
        for one in node.names
    }


def calls_of_inner_kernels() -> Iterator[tuple[str, str, tuple[str, str], bool]]:
    """Module and name of every inner kernel, what it calls, and whether it returns that as it is."""
    for module, tree in trees().items():
        imported = names_of(tree)
        for name, (kind, body) in kernels(tree).items():
            if kind != "inner_njit":
                continue
            for node in ast.walk(body):
                returned = isinstance(node, ast.Return)
                call = node.value if isinstance(node, ast.Return) else node
                if isinstance(call, ast.Call) and isinstance(call.func, ast.Name):
                    yield module, name, imported.get(call.func.id, (module, call.func.id)), returned


def test_inner_kernels_call_inner_kernels_alone():
    """A counted one may hand back an array, which nothing would ever let go of."""
    kinds = {(module, name): kind for module, tree in trees().items() for name, (kind, _) in kernels(tree).items()}
    found = list(calls_of_inner_kernels())
    assert len(found) > 100
    assert [call for call in found if kinds.get(call[2]) == "njit"] == []


def test_inner_kernels_hand_back_no_arrays():
    """Numba refuses a bare one that was not handed in, but not one in a tuple."""
    holding = {(module, name) for module, tree in trees().items() for name in named_tuples(tree)}
    assert len(holding) > 10
    assert [call for call in calls_of_inner_kernels() if call[3] and call[2] in holding] == []


def test_numba_refuses_an_inner_kernel_that_makes_an_array():
    @inner_njit(error_model="numpy")
    def makes(values):
        return np.empty(values.shape[0])[0]

    @inner_njit(error_model="numpy")
    def hands_back(values):
        return values[1:]

    for kernel in (makes, hands_back):
        with pytest.raises(NumbaError):
            kernel(np.zeros(3))


def test_an_inner_kernel_first_called_by_another_one_leaves_counted_ones_counted():
    """Numba hands options on to what a kernel calls, where that says nothing of them itself."""
    assert picked.targetoptions["_nrt"] and share_torque.targetoptions["_nrt"]


def test_without_the_option_kernels_are_counted(monkeypatch):
    monkeypatch.setattr(numba.core.cpu, "CPUTargetOptions", object)
    assert kernel_cache._counting(False) == {} == kernel_cache._counting(True)
    monkeypatch.undo()
    assert kernel_cache._counting(False) == {"_nrt": False}


def test_parts_of_arrays_live_as_long_as_they_are_used():
    """What an inner kernel reads through a part of an array is what the array holds, whoever else lets go of it."""

    @inner_njit(error_model="numpy")
    def total(values, start):
        part, result = values[start:], 0.0
        for value in part[1:]:
            result += value
        return result

    @njit(error_model="numpy")
    def many(count):
        result = 0.0
        for n in range(count):
            made = np.full(50, float(n))
            result += total(made, 9)
        return result

    assert many(1000) == 40.0 * 999.0 * 500.0
