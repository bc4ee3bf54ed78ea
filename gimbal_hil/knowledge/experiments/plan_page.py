"""The page on plan files, made from the classes that validate them.

`docs/reference/plan-file.md` is what `python -m gimbal_hil.knowledge.experiments.plan_page` prints; a test holds the
two to each other.
"""

from __future__ import annotations

from textwrap import wrap

from firmware_protocol.documents import key_table
from gimbal_hil.knowledge.experiments.plan import End, GuardPlan, Plan, SegmentPlan
from gimbal_hil.knowledge.experiments.references import SHAPES, UNITS, Reference
from sim_backend.shipped import shipped_file

_HEAD = """# Plan file

Made from `gimbal_hil/knowledge/experiments` by `python -m gimbal_hil.knowledge.experiments.plan_page`; do not edit.

An experiment of your own as a YAML file. It runs like the [sequences](experiments.md) that come with the project:

    gimbal-hil check plan.yaml                                # is it a plan?
    gimbal-hil experiment plan.yaml --out runs/mine           # on the virtual antenna, in lockstep
    gimbal-hil experiment plan.yaml --run RUN --out runs/real # through a running daemon

`gimbal-hil init` writes a first one for your antenna. `gimbal-hil check --schema plan` gives editors the keys.

```yaml
EXAMPLE```

A segment says what each axis does; an axis that it does not name is held beside one that it does, as
`supervisor.unnamed_axis` of the [configuration](configuration.md) says. Use the axis names of your model file; `outer`
and `inner` are understood too. At the end torque is switched off.
"""
_GUARDS = """
Guards are checked before the first torque of a segment and at every tick. A guard that trips brings the axes to rest
and ends the whole plan.
"""
_AXIS = """
## What an axis does

`outer: {mode: position, shape: ramp, slope_rad_s: 0.02}`: a mode, a shape, and the keys of the shape. Without `shape` a
value is held (`hold`). `mode: off` takes no further keys: the axis is free, and falls where it is out of balance.

A key that ends in `_U`, `_U/s` or `_U/s^2` below gets the unit of the mode as its ending:

"""


def plan_page() -> str:
    """Text of `docs/reference/plan-file.md`."""
    example = "".join(shipped_file("plans", "two_speeds.yaml").read_text().splitlines(keepends=True)[2:])
    parts = [_HEAD.replace("EXAMPLE", example)]
    parts += ["\n## Keys of the file\n\n", *_lines(key_table(Plan))]
    parts += ["\n## Keys of a segment\n\n", *_lines(key_table(SegmentPlan, but=("outer", "inner")))]
    parts += ["\n**An entry of `end`**: an axis, one condition, and how long it must hold.\n\n"]
    parts += [*_lines(key_table(End)), "\n**`guards`**, by axis: `{outer: {rate_rad_s: 1.0}}`.\n\n"]
    parts += [*_lines(key_table(GuardPlan)), _GUARDS, _AXIS]
    parts += ["| mode | `_U` | `_U/s` | `_U/s^2` | follows |\n", "|---|---|---|---|---|\n"]
    parts += [
        f"| `{mode.name.lower()}` | `_{units[0]}` | `_{units[1]}` | `_{units[2]}` | {_FOLLOWS[mode.name]} |\n"
        for mode, units in UNITS.items()
    ]
    parts += [
        "\nEvery shape takes `from_start: true`: its values are then relative to where the axis is at the start\n"
    ]
    parts += ["of the segment, or to the reference before it.\n"]
    for name, shape in SHAPES.items():
        parts += ["\n", *_lines(wrap(f"**`{name}`**: {_sentence(shape)}", 120)), "\n", *_lines(_keys_of(shape))]
    return "".join(parts)


_FOLLOWS = {
    "TORQUE": "torque",
    "RATE": "rate of the joint",
    "INERTIAL_RATE": "inertial rate, as the gyro reads it",
    "POSITION": "position of the joint",
    "POINTING": "a direction in space, both axes together: the joints' angles on a level base of heading zero",
}
_ENDINGS = ("_U", "_U/s", "_U/s^2")


def _keys_of(shape: type[Reference]) -> list[str]:
    lines = key_table(shape, but=("shape", "from_start"))
    for name, order in shape.quantities.items():
        lines = [line.replace(f"| `{name}` |", f"| `{name}{_ENDINGS[order]}` |") for line in lines]
    return lines


def _sentence(shape: type[Reference]) -> str:
    text = " ".join((shape.__doc__ or "").split())
    return text[:1].lower() + text[1:]


def _lines(table: list[str]) -> list[str]:
    return [f"{line}\n" for line in table]


if __name__ == "__main__":
    print(plan_page(), end="")
