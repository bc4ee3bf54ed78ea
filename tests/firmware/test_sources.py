"""The C sources: no warning from either compiler, nothing that a microcontroller lacks, one layout everywhere."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from sim_backend.firmware import DEVICE_SOURCES, PROTOCOL_FOLDER, SOURCE_FOLDER, WARNINGS, HostBench, SmallBench

ARM = (
    "arm-none-eabi-gcc",
    "-std=c11",
    "-mcpu=cortex-m4",
    "-mthumb",
    "-ffreestanding",
    f"-I{PROTOCOL_FOLDER}",
    *WARNINGS,
)
HOST = ("gcc", "-std=c11", "-Wpedantic", "-Wshadow", f"-I{PROTOCOL_FOLDER}", *WARNINGS)


def needs(tool: str, package: str) -> Callable[..., object]:
    return pytest.mark.skipif(shutil.which(tool) is None, reason=f"needs {tool} (apt install {package})")


needs_gcc = needs("gcc", "gcc")
needs_arm = needs("arm-none-eabi-gcc", "gcc-arm-none-eabi")


def run(*words: str | Path) -> str:
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def objects(folder: Path, *options: str) -> list[Path]:
    """The device as Cortex-M4 machine code, one object a source."""
    made = []
    for name in DEVICE_SOURCES:
        made.append(folder / f"{name}.o")
        run(*ARM, *options, "-c", SOURCE_FOLDER / name, "-o", made[-1])
    return made


@needs_gcc
@pytest.mark.parametrize("level", ["-O0", "-O2"])
def test_gcc_has_nothing_to_say(level: str, tmp_path: Path) -> None:
    for source in sorted(SOURCE_FOLDER.glob("*.c")):
        run(*HOST, level, "-c", source, "-o", tmp_path / "object.o")


@needs_arm
def test_the_device_is_small_and_needs_no_heap_no_library_and_no_floating_point(tmp_path: Path) -> None:
    made = objects(tmp_path, "-Os")
    wanted = set(re.findall(r" U (\S+)", run("arm-none-eabi-nm", *made)))
    defined = set(re.findall(r" [TtRr] (\S+)", run("arm-none-eabi-nm", *made)))
    # division and multiplication of 64 bits, and copying and clearing of structures: the compiler's own
    assert wanted - defined <= {"memcpy", "memset", "__aeabi_ldivmod", "__aeabi_uldivmod", "__aeabi_lmul"}
    assert not [name for name in wanted if re.match(r"__aeabi_[df]|__aeabi_[iul]+2[df]|.*alloc|free", name)]
    sizes = [row.split() for row in run("arm-none-eabi-size", *made).splitlines()[1:]]
    text, data, bss = (sum(int(row[column]) for row in sizes) for column in range(3))
    assert 2000 < text < 10_000 and (data, bss) == (0, 0)


@needs_arm
def test_no_function_calls_itself_and_the_stack_stays_small(tmp_path: Path) -> None:
    from tests.firmware.stack import deepest

    worst, chain = deepest(objects(tmp_path, "-Os", "-fstack-usage"), "gimbal_device_tick")
    assert chain[0] == "gimbal_device_tick" and 50 < worst < 1024, chain


@pytest.mark.skipif(shutil.which("cppcheck") is None, reason="needs cppcheck (apt install cppcheck)")
def test_cppcheck_has_nothing_to_say() -> None:
    checks = "--enable=warning,style,performance,portability"
    words = ("cppcheck", "--std=c11", checks, "--error-exitcode=1", "--quiet", "--suppress=missingIncludeSystem")
    run(*words, f"-I{PROTOCOL_FOLDER}", SOURCE_FOLDER)


@needs_gcc
def test_python_lays_the_memory_out_as_the_compiler_does(tmp_path: Path) -> None:
    places = ["device.drive", "device.receivers", "settings.joints[1]", "samples", "base", "supply", "advance", "sent"]
    places += [
        "device.drive.joints[1].stop_rate",
        "device.drive.joints[1].motor_torque",
        "stream.size",
        "packet.packet",
    ]
    prints = "\n".join(f'printf("%zu\\n", offsetof(gimbal_bench_t, {place}));' for place in places)
    program = tmp_path / "offsets.c"
    program.write_text(
        f'#include <stdio.h>\n#include "gimbal_bench.h"\nint main(void) {{ {prints}\n'
        'printf("%zu\\n", sizeof(gimbal_bench_t)); return 0; }\n'
    )
    run("gcc", "-std=c11", f"-I{PROTOCOL_FOLDER}", f"-I{SOURCE_FOLDER}", program, "-o", tmp_path / "offsets")
    found = [int(line) for line in run(tmp_path / "offsets").split()]
    assert found == [*(offset(HostBench, place) for place in places), ctypes.sizeof(HostBench)]


@needs_arm
def test_and_as_the_compiler_of_the_microcontroller_does(tmp_path: Path) -> None:
    # a size that is not the right one makes the array's size negative
    program = tmp_path / "size.c"
    size = ctypes.sizeof(SmallBench)
    program.write_text(f'#include "gimbal_bench.h"\nextern char right[sizeof(gimbal_bench_t) == {size} ? 1 : -1];\n')
    run(*ARM, f"-I{SOURCE_FOLDER}", "-c", program, "-o", tmp_path / "size.o")


def offset(structure: type[ctypes.Structure], place: str) -> int:
    """Offset of `a.b[1].c` in a structure of ctypes."""
    at, kind = 0, structure
    for part in place.split("."):
        name, _, index = part.partition("[")
        at += getattr(kind, name).offset
        kind = {entry[0]: entry[1] for entry in kind._fields_}[name]
        if index:
            kind = kind._type_
            at += int(index.rstrip("]")) * ctypes.sizeof(kind)
    return at
