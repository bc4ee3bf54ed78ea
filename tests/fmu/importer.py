"""An importer of FMUs (FMPy) that hands on blocks of frames as operations of FMI-LS-BUS and back.

    python -m tests.fmu.importer --ticks 1000000

compares a FMU with the antenna in Python behind the host's program, tick by tick, and says how fast each was.
"""

from __future__ import annotations

import argparse
import ctypes
import struct
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Slave

from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.proof.bench.speed import work_program
from gimbal_hil.realtime.lockstep import FramePath
from sim_backend.device import Device
from sim_backend.fmu import fmu_of
from sim_backend.model import AntennaModel, shipped_model

#: an importer in C, tick by tick: event, step, data
LOOP = """
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
int fmi3UpdateDiscreteStates(void *, bool *, bool *, bool *, bool *, bool *, double *);
int fmi3EnterStepMode(void *);
int fmi3EnterEventMode(void *);
int fmi3DoStep(void *, double, double, bool, bool *, bool *, bool *, double *);
int fmi3GetBinary(void *, const uint32_t *, size_t, size_t *, const uint8_t **, size_t);
size_t loop(void *antenna, int ticks, double step)
{
    bool a, b, c, d, e;
    double when;
    size_t all = 0, size;
    const uint8_t *data;
    uint32_t sent = 2;
    for (int k = 0; k < ticks; k++) {
        fmi3UpdateDiscreteStates(antenna, &a, &b, &c, &d, &e, &when);
        fmi3EnterStepMode(antenna);
        fmi3DoStep(antenna, k * step, step, true, &a, &b, &c, &when);
        fmi3EnterEventMode(antenna);
        fmi3GetBinary(antenna, &sent, 1, &size, &data, 1);
        all += size / 24;
    }
    return all;
}
"""
RX_DATA, TX_DATA, RX_CLOCK, TX_CLOCK = 1, 2, 3, 4
TRANSMIT, HEAD = 0x10, struct.Struct("<IIIBBH")


def operations(block: bytes) -> bytes:
    """CAN Transmit for each record of a block."""
    return b"".join(
        HEAD.pack(TRANSMIT, 24, int.from_bytes(block[at : at + 2], "little"), 0, 0, 8) + block[at + 2 : at + 10]
        for at in range(0, len(block), 10)
    )


def block_of(operations: bytes) -> bytes:
    """The records of operations that are all CAN Transmit of eight bytes."""
    found = []
    for at in range(0, len(operations), 24):
        code, length, identifier, extended, remote, size = HEAD.unpack_from(operations, at)
        assert (code, length, extended, remote, size) == (TRANSMIT, 24, 0, 0, 8)
        found.append(identifier.to_bytes(2, "little") + operations[at + 16 : at + 24])
    return b"".join(found)


class FmuAntenna:
    """An FMU ticked like a `Device`, by the calls that FMI-LS-BUS asks of an importer."""

    def __init__(self, archive: Path, folder: Path, seed: int = 0) -> None:
        extract(str(archive), str(folder))
        said = read_model_description(str(folder))
        self.step_s = float(said.defaultExperiment.stepSize)
        self.references = {variable.name: variable.valueReference for variable in said.modelVariables}
        identifier = said.coSimulation.modelIdentifier
        self.fmu = FMU3Slave(
            guid=said.guid, unzipDirectory=str(folder), modelIdentifier=identifier, instanceName="antenna"
        )
        self.fmu.instantiate(eventModeUsed=True)
        self.fmu.setInt64([self.references["seed"]], [seed])
        self.fmu.enterInitializationMode(startTime=0.0)
        self.fmu.exitInitializationMode()
        self.ticks, self.folder = 0, folder

    def tick(self, received: bytes = b"") -> bytes:
        """One bus communication point, one step of a tick, and what is sent at its end."""
        fmu = self.fmu
        if received:
            fmu.setClock([RX_CLOCK], [True])
            self.put(operations(received))
        fmu.updateDiscreteStates()
        fmu.enterStepMode()
        event, *_ = fmu.doStep(self.ticks * self.step_s, self.step_s)
        self.ticks += 1
        fmu.enterEventMode()
        if not event:
            return b""
        assert fmu.getClock([TX_CLOCK]) == [True]
        return block_of(self.sent())

    def put(self, data: bytes) -> None:
        """Set Rx_Data."""
        size, kept = ctypes.c_size_t(len(data)), ctypes.create_string_buffer(data, len(data))
        value = ctypes.cast(kept, ctypes.POINTER(ctypes.c_uint8))
        self.fmu.fmi3SetBinary(
            self.fmu.component, (ctypes.c_uint32 * 1)(RX_DATA), 1, (ctypes.c_size_t * 1)(size.value),
            (ctypes.POINTER(ctypes.c_uint8) * 1)(value), 1,
        )  # fmt: skip

    def sent(self) -> bytes:
        """Get Tx_Data."""
        (value,) = self.fmu.getBinary([TX_DATA])
        return bytes(value)

    def close(self) -> None:
        """Free the instance and its library."""
        self.fmu.terminate()
        self.fmu.freeInstance()


class Both:
    """Two antennas that hear the same; AssertionError at the first tick in which they do not say the same."""

    def __init__(self, one: Device, other: FmuAntenna) -> None:
        self.one, self.other = one, other
        self.frames = self.ticks = 0

    def tick(self, received: bytes = b"") -> bytes:
        answer = self.one.tick(received)
        assert self.other.tick(received) == answer, f"tick {self.ticks}"
        self.ticks += 1
        self.frames += len(answer) // 10
        return answer


@contextmanager
def running(model: AntennaModel, seed: int = 0) -> Iterator[FmuAntenna]:
    """A model's FMU, instantiated from an archive in a temporary folder."""
    with tempfile.TemporaryDirectory() as place:
        archive = Path(place, "antenna.fmu")
        archive.write_bytes(fmu_of(model))
        antenna = FmuAntenna(archive, Path(place, "unpacked"), seed)
        yield antenna
        antenna.close()


def compared(model: AntennaModel, ticks: int, seed: int = 0) -> Both:
    """`ticks` ticks of the host's program in front of the antenna in Python and the FMU."""
    settings = shipped_settings()
    with running(model, seed) as antenna:
        device = Device(model, seed=seed)
        both = Both(device, antenna)
        path = FramePath(settings, model, seed, device=device).with_remote(both)
        path.connect()
        path.host.command(work_program(settings))
        while both.ticks < ticks:
            path.advance(min(10_000, ticks - both.ticks))
    return both


def importer_in_c(antenna: FmuAntenna) -> Callable[[int], int]:
    """Frames that an antenna says in so many ticks, asked by an importer in C."""
    (library,) = Path(antenna.folder, "binaries").rglob("*.so")
    source, loop = Path(antenna.folder, "loop.c"), Path(antenna.folder, "loop.so")
    source.write_text(LOOP)
    subprocess.run(["cc", "-O2", "-fPIC", "-shared", source, library, "-o", loop], check=True)
    function = ctypes.CDLL(str(loop)).loop
    function.restype, function.argtypes = ctypes.c_size_t, [ctypes.c_void_p, ctypes.c_int, ctypes.c_double]
    return lambda ticks: int(function(antenna.fmu.component, ticks, antenna.step_s))


def _timed(what: str, ticks: int, work: Callable[[], object]) -> None:
    begin = time.perf_counter()
    work()
    took = time.perf_counter() - begin
    print(f"{what}: {took:.2f} s, {ticks * 1e-3 / took:.0f} times real time")


def main() -> None:
    """The command line."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("--ticks", type=int, default=20_000)
    ticks = reader.parse_args().ticks
    model = shipped_model()
    print(f"archive: {len(fmu_of(model)) / 1e6:.2f} MB")
    with running(model) as antenna:
        antenna.fmu.updateDiscreteStates()
        antenna.fmu.enterStepMode()
        _timed("one step over all ticks", ticks, lambda: antenna.fmu.doStep(0.0, ticks * antenna.step_s))
    with running(model) as antenna:
        _timed("tick by tick, from Python", 20_000, lambda: [antenna.tick() for _ in range(20_000)])
    with running(model) as antenna:
        ticked = importer_in_c(antenna)
        _timed("tick by tick, from C", ticks, lambda: ticked(ticks))
    both = compared(model, ticks)
    print(f"{both.frames} frames of {both.ticks} ticks equal")


if __name__ == "__main__":
    main()
