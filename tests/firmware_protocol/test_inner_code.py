"""Inner functions are linked into what Python calls, and become machine code only there."""

from __future__ import annotations

from typing import Any

import numba
import pytest

from firmware_protocol.compiling import compiled

pytestmark = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")


@compiled
def _halved(x: float) -> float:
    return 0.5 * x


@compiled
def _reduced(x: float) -> float:
    """Calls another one in a loop, so that nothing of it can be computed beforehand."""
    while x > 1.0:
        x = _halved(x)
    return x


def test_only_what_python_calls_becomes_machine_code() -> None:
    outer = numba.njit(lambda x: _reduced(x) + _halved(x))
    assert outer(12.0) == 0.75 + 6.0
    engine = numba.core.registry.cpu_target.target_context.codegen()._engine

    def has_machine_code(function: Any) -> bool:
        (made,) = function.overloads.values()
        return bool(engine.is_symbol_defined(made.fndesc.llvm_func_name))

    assert has_machine_code(outer)
    assert not has_machine_code(_reduced) and not has_machine_code(_halved)


def test_python_may_call_an_inner_function_all_the_same() -> None:
    assert _reduced(12.0) == 0.75 and _halved(3.0) == 1.5
