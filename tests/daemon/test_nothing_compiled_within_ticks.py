"""Compiled kernels are there before time counts: compiling or loading one within the ticks stops them for half a
second.
"""

from __future__ import annotations

import random
import sys

from numba.core.dispatcher import Dispatcher

from gimbal_hil.loop.host import FirstTest, FirstTestState, Host
from gimbal_hil.loop.settings import host_configuration, shipped_settings
from gimbal_hil.proof.bench.soak import random_program
from sim_backend.device import Device
from sim_backend.model import shipped_model

ROOMS = ("gimbal_hil", "sim_backend", "firmware_protocol")


def compiled_kernels() -> dict[str, int]:
    """Signatures of every compiled function that is loaded."""
    modules = [module for name, module in list(sys.modules.items()) if name.startswith(ROOMS)]
    return {
        f"{module.__name__}.{name}": len(value.overloads)
        for module in modules
        for name, value in list(vars(module).items())
        if isinstance(value, Dispatcher)
    }


def test_first_test_programs_stops_and_resets_compile_nothing_once_the_ticks_run() -> None:
    settings = shipped_settings()
    host, device = Host(host_configuration(settings), settings.axis_names), Device(shipped_model(), rate_hz=1000.0)
    test, draw, answer = FirstTest(host, 1e-3), random.Random(0), b""
    for tick in range(2):
        answer = device.tick(host.tick(tick, tick * 1_000_000, answer))
    before = compiled_kernels()
    for tick in range(2, 8000):
        if test.state is not FirstTestState.PASSED:
            test.before_tick()
        elif tick % 500 == 0:
            host.command(random_program(draw, 1000.0))
        for every, ask in ((1777, host.quick_stop), (1888, host.reset_fault), (1999, host.stop)):
            if tick % every == 0:
                ask()
        answer = device.tick(host.tick(tick, tick * 1_000_000, answer))
        host.events()
    assert test.state is FirstTestState.PASSED
    after = compiled_kernels()
    assert {name for name, count in after.items() if count != before.get(name)} == set()
