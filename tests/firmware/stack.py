"""Worst-case stack of a function: the stack of each function along the deepest chain of calls in the linked machine
code. That of the compiler's own helpers, which are there as machine code only, is read off their instructions.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Sequence
from pathlib import Path


def deepest(objects: Sequence[Path], top: str) -> tuple[int, list[str]]:
    """Bytes of stack of `top` and all below it, and the chain of calls that needs them; AssertionError where a function
    calls itself, or its stack is not known at compile time. What is called through pointers is not counted.
    """
    image = objects[0].with_name("image.elf")
    words = ["arm-none-eabi-gcc", "-mcpu=cortex-m4", "-mthumb", "-nostartfiles", f"-Wl,-e{top}", *map(str, objects)]
    subprocess.run([*words, "-o", str(image)], check=True, capture_output=True)
    listing = subprocess.run(["arm-none-eabi-objdump", "-d", image], capture_output=True, text=True, check=True).stdout
    frames: dict[str, int] = {}
    calls: dict[str, set[str]] = {}
    current = ""
    for line in listing.splitlines():
        if begins := re.match(r"[0-9a-f]+ <([\w.]+)>:", line):
            current = begins.group(1)
            calls[current], frames[current] = set(), 0
        elif jump := re.search(r"\t(bl|b|b\.w|b\.n)\t[0-9a-f]+ <([\w.]+)>", line):
            # a branch to the start of the function it stands in is a loop, not a call
            if jump.group(1) == "bl" or jump.group(2) != current:
                calls[current].add(jump.group(2))
        elif pushed := re.search(r"\t(?:push|stmdb\tsp!,)\s*\{([^}]*)\}", line):
            frames[current] += 4 * len(pushed.group(1).split(","))
        elif taken := re.search(r"\tsub(?:\.w|w)?\tsp, (?:sp, )?#(\d+)", line):
            frames[current] += int(taken.group(1))
    for file in objects:
        for line in file.with_suffix(".su").read_text().splitlines():
            place, size, kind = line.split("\t")
            assert kind == "static", line
            frames[place.rsplit(":", 1)[1]] = int(size)

    def below(name: str, on_the_way: tuple[str, ...]) -> tuple[int, list[str]]:
        assert name not in on_the_way, f"{name} calls itself through {on_the_way}"
        found = [below(one, (*on_the_way, name)) for one in sorted(calls[name])]
        most, chain = max(found, default=(0, []), key=lambda one: one[0])
        return frames[name] + most, [name, *chain]

    return below(top, ())
