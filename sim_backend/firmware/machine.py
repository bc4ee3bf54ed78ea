"""The C device as Cortex-M4 machine code, executed in this process by Unicorn, with the plant behind it.

Nothing of a board is imitated: the image has no start-up code and no peripherals. Its memory is shared with Python, so
the electronics are the same memory as in the library.
"""

from __future__ import annotations

import ctypes
import importlib
import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from firmware_protocol.errors import BadInputError
from sim_backend.device import FirmwareSettings
from sim_backend.firmware.antenna import BenchAntenna
from sim_backend.firmware.library import SOURCES, WARNINGS, firmware_sources
from sim_backend.firmware.structures import SmallBench
from sim_backend.model import AntennaModel

COMPILER = "arm-none-eabi-gcc"
TARGET = ("-mcpu=cortex-m4", "-mthumb", "-ffreestanding")
_FLASH, _FLASH_SIZE = 0x0800_0000, 0x10000
_RAM, _RAM_SIZE = 0x2000_0000, 0x40000
#: the bench at the start of the memory, then the block received, the stack at its end
_BLOCK = _RAM + 0x4000
_STACK_TOP, _STACK_SIZE = _RAM + _RAM_SIZE, 0x1000
#: two instructions that return: where the plant is called from, and where a call ends
_GATE, _GATE_SIZE, _END = 0x1000_0000, 0x1000, 0x1000_0010
_RETURN = bytes.fromhex("7047")
_UNTOUCHED = 0xA5


@dataclass(frozen=True)
class MachineImage:
    """Linked machine code with the addresses of its functions."""

    code: bytes
    functions: Mapping[str, int]

    @property
    def size(self) -> int:
        """Bytes of code and constants."""
        return len(self.code)


def build_image(folder: Path, changed: Mapping[str, str] | None = None, optimise: str = "-Os") -> MachineImage:
    """Compile and link the device with its bench for a Cortex-M4; `changed` as in `build_library`. BadInputError where
    the compiler is missing or has something to say.
    """
    if shutil.which(COMPILER) is None:
        raise BadInputError("the C device", f"needs {COMPILER}, which is not there", "the package gcc-arm-none-eabi")
    folder.mkdir(parents=True, exist_ok=True)
    for file, text in firmware_sources(changed).items():
        (folder / file).write_text(text, encoding="utf-8")
    warnings = ["-w"] if changed else WARNINGS
    linked = ["-nostartfiles", f"-Wl,-Ttext={_FLASH:#x}", "-Wl,-egimbal_bench_tick"]
    run_tool(folder, COMPILER, "-std=c11", optimise, *TARGET, *warnings, *linked, *SOURCES, "-o", "image.elf")
    run_tool(folder, "arm-none-eabi-objcopy", "-O", "binary", "image.elf", "image.bin")
    return MachineImage((folder / "image.bin").read_bytes(), addresses_in(folder, "Tt"))


def addresses_in(folder: Path, kinds: str) -> dict[str, int]:
    """Address of each name in the image of a folder whose kind is one of nm's letters."""
    rows = [row.split() for row in run_tool(folder, "arm-none-eabi-nm", "image.elf").splitlines()]
    return {row[2]: int(row[0], 16) for row in rows if len(row) == 3 and row[1] in kinds}


def run_tool(folder: Path, *words: str) -> str:
    """Run a tool of the compiler in a folder; answers what it prints, BadInputError where it fails."""
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise BadInputError(str(folder), f"{words[0]}: {done.stderr.strip()[:400]}", "C11 without a warning")
    return done.stdout


def _unicorn() -> ModuleType:
    """The emulator, which has no types."""
    try:
        return importlib.import_module("unicorn")
    except ImportError:
        raise BadInputError("the machine code", "needs the package unicorn", "pip install unicorn") from None


class MachineAntenna(BenchAntenna):
    """The virtual antenna with the C device as machine code."""

    def __init__(
        self,
        image: MachineImage,
        model: AntennaModel,
        settings: FirmwareSettings | None = None,
        rate_hz: float = 1000.0,
        seed: int = 0,
    ) -> None:
        self.image = image
        self.instructions = 0
        self._memory = (ctypes.c_uint8 * _RAM_SIZE)()
        self._processor = self._powered()
        super().__init__(SmallBench.from_buffer(self._memory), model, settings, rate_hz, seed)

    def _power_up(self) -> None:
        self._call("gimbal_bench_start")
        self.bench.advance = _GATE | 1

    def _powered(self) -> Any:
        unicorn = _unicorn()
        processor = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
        processor.ctl_set_cpu_model(unicorn.arm_const.UC_CPU_ARM_CORTEX_M4)
        processor.mem_map(_FLASH, _FLASH_SIZE, unicorn.UC_PROT_READ | unicorn.UC_PROT_EXEC)
        processor.mem_write(_FLASH, self.image.code)
        processor.mem_map(_GATE, _GATE_SIZE, unicorn.UC_PROT_READ | unicorn.UC_PROT_EXEC)
        processor.mem_write(_GATE, _RETURN)
        processor.mem_write(_END, _RETURN)
        readable = unicorn.UC_PROT_READ | unicorn.UC_PROT_WRITE
        processor.mem_map_ptr(_RAM, _RAM_SIZE, readable, ctypes.addressof(self._memory))
        processor.hook_add(unicorn.UC_HOOK_CODE, self._called_back, begin=_GATE, end=_GATE + 1)
        return processor

    def _call(self, name: str, *arguments: int) -> None:
        """Call a function of the image with the bench as its first argument."""
        arm = _unicorn().arm_const
        processor = self._processor
        registers = (arm.UC_ARM_REG_R0, arm.UC_ARM_REG_R1, arm.UC_ARM_REG_R2)
        for register, value in zip(registers, (_RAM, *arguments), strict=False):
            processor.reg_write(register, value)
        processor.reg_write(arm.UC_ARM_REG_SP, _STACK_TOP)
        processor.reg_write(arm.UC_ARM_REG_LR, _END | 1)
        processor.emu_start(self.image.functions[name] | 1, _END)

    def _bench_tick(self, received: bytes) -> None:
        ctypes.memmove(ctypes.addressof(self._memory) + _BLOCK - _RAM, received, len(received))
        self._call("gimbal_bench_tick", _BLOCK, len(received))

    def counted_tick(self, received: bytes = b"") -> tuple[int, int]:
        """One tick, slowly: instructions executed, and bytes of stack touched, those of the bench's functions
        included.
        """
        stack = (ctypes.c_uint8 * _STACK_SIZE).from_buffer(self._memory, _STACK_TOP - _STACK_SIZE - _RAM)
        ctypes.memset(stack, _UNTOUCHED, _STACK_SIZE)
        before, self.instructions = self.instructions, 0

        def count(*_: object) -> None:
            self.instructions += 1

        hook = self._processor.hook_add(_unicorn().UC_HOOK_CODE, count)
        # code that was translated before knows of no hook
        self._processor.ctl_flush_tb()
        try:
            self.tick(received)
        finally:
            self._processor.hook_del(hook)
            self._processor.ctl_flush_tb()
        counted, self.instructions = self.instructions, before
        touched = next((place for place, octet in enumerate(stack) if octet != _UNTOUCHED), _STACK_SIZE)
        return counted, _STACK_SIZE - touched
