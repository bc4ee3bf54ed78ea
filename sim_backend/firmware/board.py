"""The C device as the firmware of a whole board that QEMU imitates: its UART on a TCP port of this machine, motors and
sensors on a pair of pipes, at whose other end the plant is, its memory a file that is looked into here, as a debugger
looks into a board.

The board is in lockstep with whoever speaks to its UART, so it takes the time that QEMU takes.
"""

from __future__ import annotations

import ctypes
import mmap
import os
import select
import shutil
import signal
import socket
import struct
import subprocess
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from firmware_protocol.errors import BadInputError, LinkError
from firmware_protocol.links import AntennaInStep, CobsFraming, StreamLink, open_serial
from sim_backend.device import FirmwareSettings
from sim_backend.firmware.antenna import FirmwareAntenna, fill_settings
from sim_backend.firmware.electronics import BASE_SIZE, SENSED_SIZE, WANTED_SIZE
from sim_backend.firmware.library import DEVICE_SOURCES, SOURCE_FOLDER, WARNINGS, firmware_sources
from sim_backend.firmware.machine import COMPILER, TARGET, addresses_in, run_tool
from sim_backend.firmware.structures import AXES, CBase, CSettings, SmallDevice
from sim_backend.model import AntennaModel

EMULATOR = "qemu-system-arm"
_MACHINE = "mps2-an386"
_BOARD_FILES = ("board.c", "board.ld")
#: `to_plant_t` and `from_plant_t` of board.c: base readings follow the axes, the supply stands last
_TO_PLANT, _FROM_PLANT = struct.Struct("<2i2B2B2B2x"), struct.Struct("<10i9ii")
_NOT_SENSED = ctypes.sizeof(CBase) // 4 - BASE_SIZE
_STARTS_WITHIN_S = 20.0
_DEATH_OF_PARENT = 1
#: memory of the machine, of which the board's variables are in the first part (board.ld)
_MEMORY_AT, _MEMORY_SIZE = 0x2100_0000, 16 << 20


@dataclass(frozen=True)
class BoardImage:
    """The linked image of a board with the addresses of its variables."""

    elf: bytes
    variables: Mapping[str, int]


def build_board(folder: Path, changed: Mapping[str, str] | None = None) -> BoardImage:
    """Compile and link the board's image in `folder`; `changed` as in `build_library`. BadInputError where the compiler
    is missing.
    """
    if shutil.which(COMPILER) is None:
        raise BadInputError("the C device", f"needs {COMPILER}, which is not there", "the package gcc-arm-none-eabi")
    folder.mkdir(parents=True, exist_ok=True)
    for file, text in firmware_sources(changed).items():
        (folder / file).write_text(text, encoding="utf-8")
    for file in _BOARD_FILES:
        shutil.copy(SOURCE_FOLDER / "board" / file, folder / file)
    warnings = ["-w"] if changed else WARNINGS
    linked = ["-nostartfiles", "-Tboard.ld", "board.c", *DEVICE_SOURCES, "-o", "image.elf"]
    run_tool(folder, COMPILER, "-std=c11", "-Os", *TARGET, *warnings, *linked)
    return BoardImage((folder / "image.elf").read_bytes(), addresses_in(folder, "bB"))


class _Uart(StreamLink):
    """The host's end of the board's UART; while it waits the plant is served."""

    def __init__(self, board: BoardAntenna, port: str) -> None:
        self._board = board
        super().__init__("QEMU", lambda: open_serial(port, 0), CobsFraming())

    def wait(self, timeout_ns: int) -> bool:
        """Until bytes have come, or a record of the board was answered."""
        return self._board.serve(timeout_ns * 1e-9, self.fileno())


class BoardAntenna(FirmwareAntenna):
    """The virtual antenna with the firmware of a board in QEMU. `port` is its UART as a serial link's
    `socket://host:port`; `tick` opens it, unless another program is to speak to it while `serve` lets the plant run.
    """

    def __init__(
        self,
        image: BoardImage,
        model: AntennaModel,
        settings: FirmwareSettings | None = None,
        rate_hz: float = 1000.0,
        seed: int = 0,
    ) -> None:
        super().__init__(model, settings, rate_hz, seed)
        if shutil.which(EMULATOR) is None:
            raise BadInputError("the board", f"needs {EMULATOR}, which is not there", "the package qemu-system-arm")
        self._folder = tempfile.TemporaryDirectory()
        self._antenna: AntennaInStep | None = None
        number = _free_port()
        self.port = f"socket://127.0.0.1:{number}"
        self._to_plant = self._from_plant = -1
        self._emulator: subprocess.Popen[bytes] | None = None
        self._output = Path(self._folder.name) / "qemu.txt"
        try:
            self._start(image, Path(self._folder.name), number)
        except BaseException:
            self.close()
            raise

    def _start(self, image: BoardImage, folder: Path, port: int) -> None:
        (folder / "image.elf").write_bytes(image.elf)
        pipes = [folder / name for name in ("to_plant", "from_plant")]
        for pipe in pipes:
            os.mkfifo(pipe)
        # opened both ways, so that neither side waits for the other
        self._to_plant, self._from_plant = (os.open(pipe, os.O_RDWR) for pipe in pipes)
        own = CSettings()
        fill_settings(own, self.electronics, len(self.model.axes))
        os.write(self._from_plant, bytes(own) + self._readings())
        with (folder / "memory").open("w+b") as file:
            file.truncate(_MEMORY_SIZE)
            self._memory = mmap.mmap(file.fileno(), _MEMORY_SIZE)
        memory = f"memory-backend-file,id=memory,size={_MEMORY_SIZE},mem-path=memory,share=on"
        line = f"tcp:127.0.0.1:{port},server=on,wait=off,nodelay=on"
        words = [EMULATOR, "-machine", f"{_MACHINE},memory-backend=memory", "-object", memory, "-kernel", "image.elf"]
        words += ["-nographic", "-monitor", "none", "-serial", line]
        words += ["-semihosting-config", "enable=on,target=native"]
        with self._output.open("wb") as output:
            self._emulator = subprocess.Popen(
                words,
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=output,
                preexec_fn=_die_with_parent,
            )
        self._await_start(image.variables)

    def _await_start(self, addresses: Mapping[str, int]) -> None:
        """Until the board waits for its first edge; its variables are known then."""
        places = {name: address - _MEMORY_AT for name, address in addresses.items()}
        end = time.monotonic() + _STARTS_WITHIN_S
        while self._memory[places["started"]] == 0:
            self._hold_emulator_alive()
            if time.monotonic() > end:
                raise LinkError(f"QEMU did not start the board within {_STARTS_WITHIN_S:g} s")
            time.sleep(0.005)
        self._look_into(
            SmallDevice.from_buffer(self._memory, places["device"]),
            CSettings.from_buffer(self._memory, places["settings"]),
        )
        self._supply = np.frombuffer(self._memory, "<i4", 1, places["from_plant"] + _FROM_PLANT.size - 4)

    def _hold_emulator_alive(self) -> None:
        if self._emulator is not None and self._emulator.poll() is not None:
            raise LinkError(f"QEMU ended with {self._emulator.returncode}: {self._output.read_text()[-300:].strip()}")

    def serve(self, timeout_s: float, beside: int = -1) -> bool:
        """Wait for the board's next record at most so long, answer it, say whether the descriptor `beside` can be read;
        LinkError where QEMU has ended.
        """
        ready = select.select([self._to_plant, *([beside] if beside >= 0 else [])], [], [], timeout_s)[0]
        if self._to_plant in ready:
            self._pass_record()
        elif not ready:
            self._hold_emulator_alive()
        return beside in ready

    def _pass_record(self) -> None:
        values = _TO_PLANT.unpack(os.read(self._to_plant, _TO_PLANT.size))
        for axis in range(AXES):
            self._wanted[WANTED_SIZE * axis : WANTED_SIZE * (axis + 1)] = values[axis::AXES]
        self._advance_plant()
        os.write(self._from_plant, self._readings())

    def _readings(self) -> bytes:
        sensed = self._sensed[: AXES * SENSED_SIZE].reshape(AXES, SENSED_SIZE).T.reshape(-1).tolist()
        base = self._sensed[AXES * SENSED_SIZE :].tolist()
        return _FROM_PLANT.pack(*sensed, *base, *([0] * _NOT_SENSED), int(self.electronics.supply))

    def _firmware_tick(self, received: bytes) -> bytes:
        if self._antenna is None:
            self._antenna = AntennaInStep(_Uart(self, self.port))
        return self._antenna.tick(received)

    def set_supply(self, supply_v: float) -> None:
        """Let the supply have another voltage from the next tick on, as in a library: the board has its reading."""
        super().set_supply(supply_v)
        self._supply[0] = self.electronics.supply

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """See `Device`; the reading of the supply, which comes before a tick, with them."""
        return super().arrays | {"supply": self._supply}

    def close(self) -> None:
        """End QEMU and take its files away."""
        if self._antenna is not None:
            self._antenna.close()
        if self._emulator is not None:
            self._emulator.kill()
            self._emulator.wait()
        for descriptor in (self._to_plant, self._from_plant):
            if descriptor >= 0:
                os.close(descriptor)
        self._to_plant = self._from_plant = -1
        self._folder.cleanup()


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _die_with_parent() -> None:
    """An emulator whose process was killed has nobody left to end it (Linux)."""
    ctypes.CDLL(None).prctl(_DEATH_OF_PARENT, signal.SIGKILL)
