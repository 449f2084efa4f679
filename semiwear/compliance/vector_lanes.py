"""Vectors of numbers in compiled kernels: `load` and `store` them, add and multiply them like single numbers.

The compiler does not vectorise loops that read and write an array at many positions at a time, since it
cannot exclude that these overlap.
"""

from __future__ import annotations

import operator
from collections.abc import Callable

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, models, register_model

from semiwear.kernel_cache import njit
from semiwear.untyped import CompilerPart

BYTES = 32  # of a vector: twice as much does not pay, since the numbers of a transform leave the first-level cache
_IR = {types.float32: ir.FloatType(), types.float64: ir.DoubleType()}


class _Lanes(types.Type):
    def __init__(self, dtype: CompilerPart):
        self.dtype = dtype
        self.count = 8 * BYTES // dtype.bitwidth
        super().__init__(name=f"Lanes({dtype})")


@register_model(_Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: CompilerPart, kind: _Lanes):
        super().__init__(manager, kind, _vector(kind.dtype, kind.count))


def _vector(dtype: CompilerPart, count: int) -> ir.VectorType:
    return ir.VectorType(_IR[dtype], count)


def _convert(
    builder: CompilerPart, value: CompilerPart, old: CompilerPart, new: CompilerPart, count: int
) -> CompilerPart:
    if old == new:
        return value
    return (builder.fptrunc if new == types.float32 else builder.fpext)(value, _vector(new, count))


def _pointer(
    context: CompilerPart,
    builder: CompilerPart,
    kind: CompilerPart,
    array: CompilerPart,
    index: CompilerPart,
    count: int,
) -> CompilerPart:
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), _vector(kind.dtype, count).as_pointer())


@intrinsic
def _lanes_of(typing: CompilerPart, array: CompilerPart) -> CompilerPart:
    """Count of numbers that `load` reads in the precision of an array; a constant of the compiled code."""
    count = _Lanes(array.dtype).count

    def generate(context: CompilerPart, builder: CompilerPart, sig: CompilerPart, args: CompilerPart) -> CompilerPart:
        return context.get_constant(types.intp, count)

    return types.intp(array), generate


@intrinsic
def _load(typing: CompilerPart, source: CompilerPart, index: CompilerPart, like: CompilerPart) -> CompilerPart:
    """Numbers of a flat contiguous array from an index on, in the precision of the array `like`."""
    lanes = _Lanes(like.dtype)

    def generate(context: CompilerPart, builder: CompilerPart, sig: CompilerPart, args: CompilerPart) -> CompilerPart:
        pointer = _pointer(context, builder, source, args[0], args[1], lanes.count)
        value = builder.load(pointer, align=source.dtype.bitwidth // 8)
        return _convert(builder, value, source.dtype, like.dtype, lanes.count)

    return lanes(source, types.intp, like), generate


@intrinsic
def _store(typing: CompilerPart, target: CompilerPart, index: CompilerPart, value: CompilerPart) -> CompilerPart:
    """Write numbers into a flat contiguous array from an index on, in the array's precision."""

    def generate(context: CompilerPart, builder: CompilerPart, sig: CompilerPart, args: CompilerPart) -> CompilerPart:
        converted = _convert(builder, args[2], value.dtype, target.dtype, value.count)
        pointer = _pointer(context, builder, target, args[0], args[1], value.count)
        builder.store(converted, pointer, align=target.dtype.bitwidth // 8)
        return context.get_dummy_value()

    return types.void(target, types.intp, value), generate


lanes_of: CompilerPart = _lanes_of
load: CompilerPart = _load
store: CompilerPart = _store


def _define(operation: Callable[..., CompilerPart], instruction: str) -> None:
    """Define an operation between vectors, and between a vector and a number."""

    @infer_global(operation)
    class _Template(AbstractTemplate):
        key = operation

        def generic(self, args: CompilerPart, kws: CompilerPart) -> CompilerPart:
            if len(args) != 2 or not isinstance(args[0], _Lanes):
                return None
            if args[1] == args[0]:
                return signature(args[0], *args)
            return signature(args[0], args[0], args[0].dtype) if isinstance(args[1], types.Float) else None

    def emit(builder: CompilerPart, one: CompilerPart, other: CompilerPart) -> CompilerPart:
        return getattr(builder, instruction)(one, other, flags=("contract",))

    @lower_builtin(operation, _Lanes, _Lanes)
    def _both(context: CompilerPart, builder: CompilerPart, sig: CompilerPart, args: CompilerPart) -> CompilerPart:
        return emit(builder, *args)

    @lower_builtin(operation, _Lanes, types.Float)
    def _one_for_all(
        context: CompilerPart, builder: CompilerPart, sig: CompilerPart, args: CompilerPart
    ) -> CompilerPart:
        kind = _vector(sig.args[0].dtype, sig.args[0].count)
        nothing = ir.Constant(kind, ir.Undefined)
        first = builder.insert_element(nothing, args[1], ir.Constant(ir.IntType(32), 0))
        everywhere = ir.Constant(ir.VectorType(ir.IntType(32), kind.count), [0] * kind.count)
        return emit(builder, args[0], builder.shuffle_vector(first, nothing, everywhere))


_define(operator.add, "fadd")
_define(operator.sub, "fsub")
_define(operator.mul, "fmul")


@njit(cache=True)
def _probe(one, other):  # type: ignore[no-untyped-def]
    count = lanes_of(one)
    store(other, 0, load(one, 0, one) * 2.0 + load(one, count, one) * load(one, count, one))
    return count


def work() -> bool:
    """Whether vectors give the same results as numbers; raises the error of numba if they do not compile."""
    one, other = np.arange(64.0), np.zeros(64, np.float32)
    count = BYTES // 8
    expected = 2.0 * one[:count] + one[count : 2 * count] ** 2
    return bool(_probe(one, other) == count and (other[:count] == expected).all() and not other[count:].any())
