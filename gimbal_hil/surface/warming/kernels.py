"""Every kernel that a command may ask for, each called once as the commands call it: that compiles it for this machine.

A kernel is compiled for the types of its arguments, so it is reached through the code that really calls it, with
the least data that this code takes.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from firmware_protocol.interpreter import apart_from_the_users_folder

#: a log that the scored band's filters fit into
_ROWS, _PERIOD_S, _BAND_HZ = 4000, 1e-3, 25.0


@dataclass(frozen=True)
class Kernel:
    """A compiled function: its short name, what it is for, and a call that asks for it."""

    name: str
    text: str
    ask: Callable[[], object]


def _antenna() -> None:
    from sim_backend.device import Device
    from sim_backend.model import shipped_model

    Device(shipped_model()).tick()


def _host() -> None:
    from gimbal_hil.loop.host import Host
    from gimbal_hil.loop.settings import host_configuration, shipped_settings

    settings = shipped_settings()
    Host(host_configuration(settings), settings.axis_names).tick(0, 0, b"")


def _lockstep() -> None:
    from gimbal_hil.loop.settings import shipped_settings
    from gimbal_hil.realtime.lockstep import CompiledPath
    from sim_backend.model import shipped_model

    CompiledPath(shipped_settings(), shipped_model()).advance(1)


def _blocks() -> None:
    from gimbal_hil.loop.settings import shipped_settings
    from gimbal_hil.realtime.lockstep import FramePath
    from sim_backend.model import shipped_model

    FramePath(shipped_settings(), shipped_model()).advance(1)


def _flights() -> None:
    from gimbal_hil.loop.settings import shipped_settings
    from gimbal_hil.realtime.lockstep import ERROR_COLUMNS, ErringNavigation, FlightPath, FlownBase
    from sim_backend.model import shipped_model

    still = np.zeros((8, 3))
    base = FlownBase(still, still, _PERIOD_S)
    navigation = ErringNavigation(np.zeros((1, ERROR_COLUMNS), dtype=np.int64), 0.0, 1.0 / _PERIOD_S)
    FlightPath(shipped_settings(), shipped_model(), 0, base, navigation).fly(1)


def _laws() -> None:
    from gimbal_hil.loop.settings import shipped_settings
    from gimbal_hil.realtime.lockstep import LawPath
    from sim_backend.model import shipped_model

    LawPath(shipped_settings(), shipped_model(), 0, np.zeros((2, 2, 3))).advance(1, until_done=True)


def _plant() -> None:
    from sim_backend.model import shipped_model
    from sim_backend.plant import Plant

    Plant(shipped_model()).run(np.zeros((1, 2)))


def _observer() -> None:
    from sim_backend.model import shipped_model
    from sim_backend.observer import INPUTS, ModelObserver

    ModelObserver(shipped_model(), 1000.0, 30.0).observe(np.zeros((1, INPUTS)))


def _rigid_body() -> None:
    from gimbal_hil.data.signals import RigidBody, SignalsTable
    from sim_backend.model import shipped_model

    model = shipped_model()
    rest = np.zeros((2, len(model.axes)))
    table = SignalsTable.of(model.axes, np.array([0.0, _PERIOD_S]), {})
    RigidBody(model).along(table, rest, rest)


def _friction_fit() -> None:
    from gimbal_hil.knowledge.identification import AxisRecord, friction_of, simulate_axis
    from sim_backend.model import shipped_model

    model = shipped_model()
    simulate_axis(AxisRecord("", _PERIOD_S, np.zeros(2), np.zeros(2)), 1.0, friction_of(model, model.axes[0]))


def _search() -> None:
    from gimbal_hil.data.signals import SignalsTable
    from gimbal_hil.knowledge.discrepancy import Twin, record_of
    from sim_backend.model import shipped_model

    model = shipped_model()
    time_s = _PERIOD_S * np.arange(_ROWS, dtype=np.float64)
    columns = {f"{axis}.position": 0.1 * np.sin(time_s) for axis in model.axes}
    columns |= {f"{axis}.torque": np.zeros(_ROWS) for axis in model.axes}
    record = record_of(SignalsTable.of(model.axes, time_s, columns), model, _BAND_HZ, "")
    twin = Twin(model, (record,))
    structure = twin.structure(())
    twin.applied(structure, structure.P, 0)


def _thesis() -> None:
    from gimbal_hil.proof.thesis import ask_for_kernels

    ask_for_kernels()


def _bench() -> None:
    from gimbal_hil.proof.bench import ask_for_kernels

    ask_for_kernels()


def ask_elsewhere(*names: str) -> None:
    """Ask for kernels, one after the other, in a process of its own that yields to this one. Who needs one before it is
    there compiles it as well.
    """
    program = (
        "import os; from gimbal_hil.surface.warming import KERNELS; os.nice(5)\n"
        f"for name in {names!r}: next(kernel for kernel in KERNELS if kernel.name == name).ask()"
    )
    nowhere = subprocess.DEVNULL
    with apart_from_the_users_folder():
        subprocess.Popen([sys.executable, "-c", program], stdin=nowhere, stdout=nowhere, stderr=nowhere)


#: in the order in which a newcomer needs them
KERNELS = (
    Kernel("antenna", "virtual antenna, tick by tick", _antenna),
    Kernel("host", "host, tick by tick (daemon)", _host),
    Kernel("lockstep", "both in one loop (experiment)", _lockstep),
    Kernel("blocks", "both in one loop, with every frame (tests of one's own)", _blocks),
    Kernel("flights", "both in one loop, with errors of navigation (point --certify)", _flights),
    Kernel("laws", "both in one loop, closed by another law (bench pointing)", _laws),
    Kernel("observer", "model beside the antenna (daemon)", _observer),
    Kernel("rigid_body", "rigid body along a log (identify, discrepancy)", _rigid_body),
    Kernel("friction_fit", "friction of one axis (identify)", _friction_fit),
    Kernel("search", "balance of torques (discrepancy, improve)", _search),
    Kernel("plant", "plant alone (simulated drives)", _plant),
    Kernel("thesis", "thesis (experiment thesis)", _thesis),
    Kernel("bench", "yardsticks (bench)", _bench),
)
