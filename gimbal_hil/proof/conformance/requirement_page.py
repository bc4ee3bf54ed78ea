"""The page on the requirements, made from their file.

`docs/reference/conformance.md` is what `python -m gimbal_hil.proof.conformance.requirement_page` prints; a test holds
the two to each other.
"""

from __future__ import annotations

from gimbal_hil.proof.conformance.requirements import GROUPS, Requirement, shipped_requirements

_HEAD = """# Conformance

Made from `gimbal_hil/proof/conformance/requirements.yaml` by
`python -m gimbal_hil.proof.conformance.requirement_page`; do not edit.

What an antenna's firmware must do so that this software can control it, as COUNT numbered requirements, and the command
that checks each on whatever answers on a link:

    gimbal-hil conformance                                  # the virtual antenna in this process
    gimbal-hil conformance --link cortex-m                  # the C device as machine code; --link c as a library
    gimbal-hil conformance --link qemu                      # as the image of a board in an emulator, over its UART
    gimbal-hil conformance --link serial:/dev/ttyUSB0       # your electronics; also unix:, socketcan:, slcan:
    gimbal-hil conformance --link unix:PATH --lockstep      # an antenna that waits, as gimbal-hil plant --lockstep
    gimbal-hil conformance --config antenna.yaml --without-motion --junit conformance.xml
    gimbal-hil conformance --only D-01 --only D-02          # some of them; a letter stands for its group

Each ends as **passed**, **failed**, **not shown** (the antenna leaves out something optional) or **skipped** (it would
move the antenna, and `--without-motion` was given). The command ends with 1 when one has failed. `--out` gets
`conformance.json`, `report.html` and, for each requirement, a [run folder](run-folder.md) with every frame of its
check.

**Some checks move the antenna**: short torques on one axis at a time, marked *moves* below. Give each axis room, and
choose their size with `--torque-share` (of 16.4 N m times two to the axis' torque exponent; 0.2 unless given). No axis
is enabled in the others, so a holding brake stays closed.

Times are counted in ticks of the antenna, so a slow tester gives no wrong result. If a check fails while the tester
itself was late, it is repeated, at most three times, and the number of tries is reported.

The checks cannot turn the antenna by hand or make its sensors fail: travel limits, overspeed, winding temperature,
supply and failing sensors are not checked. [Write your own firmware](../how-to/write-your-firmware.md) says what the
firmware must do then.

| | passed | takes | mutants found |
|---|---|---|---|
| the virtual antenna in this process | 37 | 14 s | 67 of 67 |
| over a Unix socket, over a pseudo-terminal, in real time | 37, 37 | 84 s, 90 s | |
| the same with `--lockstep` | 37, 37 | 46 s, 167 s | |
| the C device as a library | 37 | 13 s | 67 of 67 |
| as machine code | 37 | 20 s | 67 of 67 |
| as the image of a board in QEMU | 37 | 69 s | 67 of 67 |

Measured on two cores beside other work. A mutant is the drive with one guard removed (`pytest -m heavy
tests/firmware`).
"""


def conformance_page() -> str:
    """Text of `docs/reference/conformance.md`."""
    requirements = shipped_requirements()
    parts = [_HEAD.replace("COUNT", str(len(requirements)))]
    for letter, heading in GROUPS.items():
        parts.append(f"\n## {heading}\n\n| | requirement | reason | limits |\n|---|---|---|---|\n")
        parts += [_row(one) for one in requirements if one.id.startswith(letter)]
    table = next(one for one in requirements if one.transitions)
    parts.append(f"\n## The table of {table.id}\n\n| in state | on | go to |\n|---|---|---|\n")
    parts += [f"| {s} | {r} | {to} |\n" for s, row in table.transitions.items() for r, to in row.items()]
    parts.append("\nEvery other request leaves the state as it is.\n")
    return "".join(parts)


def _row(one: Requirement) -> str:
    marks = [word for word, holds in (("*moves*", one.moves), ("*optional*", one.optional)) if holds]
    limits = ", ".join(f"`{name}` {value:g}" for name, value in one.limits.items())
    return f"| {one.id} | {' '.join([one.title, *marks])} | {one.why} | {limits} |\n"


if __name__ == "__main__":
    print(conformance_page(), end="")
