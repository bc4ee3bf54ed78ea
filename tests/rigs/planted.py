"""One number of a rig's model planted wrong: told, honestly not judged, passed over in silence, or denied?

    GIMBAL_HIL_DATA=... python -m tests.rigs.planted FOLDER --seed 1 --joints 60 --rows 'emps*'

Inertia, Coulomb, viscous, unbalance and torque constant by 0.5, 0.7, 1.4 and 2: on measured rigs, and on joints that
MuJoCo moves with a resonance, a payload or a ripple that the model does not know. A torque constant is planted in the
log: every torque of it times the factor. What has been asked stays in FOLDER, and an interrupted run goes on.
"""

from __future__ import annotations

import argparse
import csv
import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from fnmatch import fnmatch
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from tests.rigs.bam import write_bam
from tests.rigs.data import DATA
from tests.rigs.dd2dof import write_dd2dof
from tests.rigs.drawn import COULOMB_PATHS, INERTIA, VISCOUS, Hidden, drawn_joint, write_drawn
from tests.rigs.emps import write_emps
from tests.rigs.odrive import write_odrive
from tests.rigs.outcome import Outcome, Planted, outcome
from tests.rigs.rig import Rig
from tests.rigs.told import Row, ask, in_words

#: what is planted -> numbers of the model; the torque constant is in the logs
NUMBERS: dict[str, tuple[str, ...]] = {
    "inertia": (INERTIA,),
    "coulomb": COULOMB_PATHS,
    "viscous": (VISCOUS,),
    "static_unbalance": ("body.cog.y",),
    "torque_gain": (),
}
FACTORS = (0.5, 0.7, 1.4, 2.0)
#: what a drawn joint has and no model of it knows, in the sizes of `tests.rigs.drawn`, and its name
BESIDE: dict[str, tuple[Mapping[str, float], str]] = {
    "a resonance": ({"flexible": 0.4}, "structural_resonance"),
    "a payload": ({"unbalance": 0.6}, "static_unbalance"),
    "a ripple": ({"ripple": 0.15}, "cogging"),
}
JOINT_MOTIONS = ("sines", "moves")


@dataclass(frozen=True)
class Measured:
    """A rig: who writes it, the logs that are fitted and held out, numbers that its model has, and what is known to be
    there beside them (the SOURCE.md of its data).
    """

    write: Callable[[Path, Mapping[str, float]], Rig]
    fitted: tuple[str, ...]
    holdout: tuple[str, ...]
    numbers: tuple[str, ...]
    beside: frozenset[str]


RIGS: dict[str, Measured] = {
    "emps": Measured(
        write_emps,
        ("DATA_EMPS",),
        ("DATA_EMPS_PULSES",),
        ("inertia", "coulomb", "viscous", "torque_gain"),
        frozenset(
            {"coulomb_asymmetry", "viscous_asymmetry", "quadratic_drag", "stribeck", "torque_offset", "cogging"}
            | {"transport_delay", "actuator_lag"}
        ),
    ),
    "odrive": Measured(
        write_odrive,
        ("slow2/nocomp_0",),
        ("slow2/nocomp_1",),
        ("inertia", "coulomb", "viscous", "torque_gain"),
        frozenset({"cogging"}),
    ),
    # its friction is assumed and the rod is not weighed: numbers of the model may be off by themselves
    "bam": Measured(
        write_bam,
        ("kp400_sin_sin", "kp400_sin_time_square"),
        ("kp400_up_and_down",),
        ("inertia", "coulomb", "viscous", "torque_gain"),
        frozenset({"static_unbalance", "load_dependent_friction", "stribeck", "coulomb", "viscous", "inertia"}),
    ),
    "dd2dof": Measured(
        write_dd2dof,
        ("cin_05_exp", "cin_n10_exp", "cin_60_exp", "cin_n90_exp"),
        ("cin_10_exp", "cin_n60_exp"),
        ("inertia", "coulomb", "viscous", "static_unbalance", "torque_gain"),
        frozenset({"coulomb_asymmetry", "viscous_asymmetry", "stribeck", "torque_offset"}),
    ),
}


def rows(folder: Path, seed: int, joints: int, factors: tuple[float, ...]) -> Iterator[tuple[str, Planted, Callable]]:
    """Every row by name, with what is planted in it and who writes its files; rigs in turn."""
    kept: list[tuple[str, Planted, Callable]] = []
    for factor in factors:
        for name, rig in RIGS.items():
            for what in rig.numbers:
                called = f"{name} {what} x {factor:g}"
                kept.append(
                    (called, Planted(what, factor, rig.beside), _writer(folder, called, rig, name, what, factor))
                )
    drawn = [_joint(folder, seed, k) for k in range(joints)]
    for k in range(max(len(kept), len(drawn))):
        yield from kept[k : k + 1]
        yield from drawn[k : k + 1]


def _writer(folder: Path, called: str, rig: Measured, name: str, what: str, factor: float) -> Callable[[], Row]:
    def write() -> Row:
        paths = ("body.mass",) if (name, what) == ("emps", "inertia") else NUMBERS[what]
        written = rig.write(folder / called.replace(" ", "_"), dict.fromkeys(paths, factor))
        if what == "torque_gain":
            written = _scaled_torque(written, rig.fitted + rig.holdout, factor)
        return Row(called, written, rig.fitted, rig.holdout, what)

    return write


def _joint(folder: Path, seed: int, k: int) -> tuple[str, Planted, Callable[[], Row]]:
    """Joint number `k` of a seed: every number by every factor, each time beside another thing."""
    besides, errors = list(BESIDE), list(product(NUMBERS, FACTORS))
    turn, place = divmod(k, len(errors))
    what, factor = errors[place]
    beside = besides[(place + turn) % len(besides)]
    sizes, true = BESIDE[beside]
    motion = JOINT_MOTIONS[(place // len(besides) + turn) % len(JOINT_MOTIONS)]
    called = f"joint {seed}-{k:02d} {what} x {factor:g} beside {beside}, {motion}"

    def write() -> Row:
        paths = ("body.cog.x",) if what == "static_unbalance" else NUMBERS[what]
        stated = {"unbalance": 0.6, "stated": 1.0} if what == "static_unbalance" else {}
        hidden = Hidden(frozenset({true}), dict.fromkeys(paths, factor), {**sizes, **stated})
        joint = replace(drawn_joint(np.random.default_rng((seed, k, 3))), motion=motion)
        written = write_drawn(folder / called.replace(" ", "_"), joint, hidden, 1000 * seed + k)
        written = _scaled_torque(written, tuple(written.logs), factor) if what == "torque_gain" else written
        return Row(called, written, ("first",), ("second",), what)

    return called, Planted(what, factor, frozenset({true})), write


def _scaled_torque(rig: Rig, names: tuple[str, ...], factor: float) -> Rig:
    for path in (rig.logs[name] for name in names):
        with path.open(newline="") as file:
            head, *body = list(csv.reader(file))
        column = next(k for k, word in enumerate(head) if word.endswith(".torque"))
        for row in body:
            row[column] = repr(factor * float(row[column]))
        with path.open("w", newline="") as file:
            csv.writer(file).writerows([head, *body])
    return rig


def line(name: str, said: Mapping[str, Any], planted: Planted) -> str:
    """A row of the table."""
    how, why = outcome(said, planted)
    return f"| {name} | {how.value} | {in_words(dict(said))} | {why} | {said.get('cpu_s', 0.0):.0f} |"


def table(found: Mapping[str, tuple[Mapping[str, Any], Planted]]) -> str:
    """Markdown: every row, the worst outcomes first, and how many there are of each."""
    how = {name: outcome(*one)[0] for name, one in found.items()}
    order = list(Outcome)
    lines = ["| planted | outcome | said | why | processor, s |", "|---|---|---|---|---|"]
    lines += [line(name, *found[name]) for name in sorted(found, key=lambda name: -order.index(how[name]))]
    counts = Counter(how.values())
    return "\n".join([*lines, "", ", ".join(f"{counts[one]} {one.value}" for one in order if counts[one])])


def main() -> None:
    """The command line."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("folder", type=Path)
    reader.add_argument("--seed", type=int, default=1, help="of the drawn joints")
    reader.add_argument("--joints", type=int, default=60)
    reader.add_argument("--factors", default=",".join(f"{one:g}" for one in FACTORS), help="of the measured rigs")
    reader.add_argument("--rows", default="*", help="patterns of names, comma between")
    reader.add_argument("--table", action="store_true", help="only print what has been asked")
    chosen = reader.parse_args()
    factors = tuple(float(one) for one in chosen.factors.split(","))
    found: dict[str, tuple[Mapping[str, Any], Planted]] = {}
    for name, planted, write in rows(chosen.folder / "files", chosen.seed, chosen.joints, factors):
        kept = chosen.folder / f"{name}.json"
        measured = DATA.is_dir() or name.startswith("joint")
        if not any(fnmatch(name, one) for one in chosen.rows.split(",")) or not measured:
            continue
        if not kept.exists():
            if chosen.table:
                continue
            said = ask(write(), chosen.folder / "out" / name.replace(" ", "_"))
            kept.write_text(json.dumps(said), encoding="utf-8")
        found[name] = json.loads(kept.read_text(encoding="utf-8")), planted
        if not chosen.table:
            print(line(name, *found[name]), flush=True)
    print(table(found))


if __name__ == "__main__":
    main()
