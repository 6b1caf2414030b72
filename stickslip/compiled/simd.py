"""The loop over lanes, which compiles a scalar function to vector instructions for many points."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

# By default the vectoriser uses half the width of an AVX-512 machine and one vector at a time, so
# that a step waits for its own results. Two vectors at a time make it 1.3 to 1.8 times as fast. If
# registers are shorter, the compiler splits a vector into several, with the same effect.
VECTOR = 8
"""Lanes per vector of a lane loop."""

_INTERLEAVED = 2

LANES = VECTOR * _INTERLEAVED
"""The number of lanes of a lane loop is a multiple of this."""


@intrinsic
def _for_lanes(typing_context: Any, lanes: Any, body: Any, arguments: Any) -> Any:
    """Call `body(lane, *arguments)` for each lane in a loop that is compiled to vectors.

    `lanes` must be a multiple of LANES, and `body` an `inline` function without branches, calls or
    loops, whose lanes share no element. Otherwise the loop becomes scalar code, which gives the
    same results but is slow (tests inspect the assembly).
    """
    signature = types.void(lanes, body, arguments)
    call = (types.int64, *arguments.types)

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        count, _, packed = values
        called = signature.args[1].get_call_type(context.typing_context, call, {})
        function = context.get_function(signature.args[1], called)
        integer = ir.IntType(64)
        before = builder.block
        loop = builder.function.append_basic_block("lanes")
        after = builder.function.append_basic_block("lanes.end")
        builder.branch(loop)
        builder.position_at_end(loop)
        lane = builder.phi(integer)
        lane.add_incoming(integer(0), before)
        function(builder, [lane, *cgutils.unpack_tuple(builder, packed)])
        following = builder.add(lane, integer(1), flags=["nuw", "nsw"])
        lane.add_incoming(following, builder.block)
        more = builder.icmp_signed("<", following, count)
        branch = builder.cbranch(more, loop, after)
        branch.set_metadata("llvm.loop", _loop_hints(builder.module))
        builder.position_at_end(after)
        return context.get_dummy_value()

    return signature, codegen


for_lanes: Any = _for_lanes  # Numba's type hints do not cover the call of an intrinsic


def _loop_hints(module: Any) -> Any:
    """Return LLVM's metadata of a loop: vector width, vectors at a time, no earlier unrolling."""
    hints = [
        [ir.MetaDataString(module, "llvm.loop.vectorize.enable"), ir.IntType(1)(1)],
        [ir.MetaDataString(module, "llvm.loop.vectorize.width"), ir.IntType(32)(VECTOR)],
        [ir.MetaDataString(module, "llvm.loop.interleave.count"), ir.IntType(32)(_INTERLEAVED)],
        [ir.MetaDataString(module, "llvm.loop.unroll.disable")],
    ]
    metadata = module.add_metadata([module.add_metadata(hint) for hint in hints])
    metadata.operands = (metadata, *metadata.operands)  # a loop's metadata begins with itself
    return metadata
