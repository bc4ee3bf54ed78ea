"""What comes of it when the feedback of a drive of another make is wrong: a matrix of `fault_rows`, makes and motions.

`python -m tests.adapters.faults MAKE... --out FILE` adds the outcomes that are not in FILE yet, `--seconds` at most;
`--page FILE...` prints the page.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from textwrap import fill

from firmware_protocol.adapters import AxisSample
from gimbal_hil.loop.host import HostState
from sim_backend.layout import RATE
from tests.adapters.fault_rows import KEPT, MOTIONS, ROWS, Row, Seen, Spoil
from tests.adapters.rig import AdapterRig, memory_buses
from tests.adapters.servo import mapped_rig

MAKES = ("moteus", "odrive", "cia402", "dbc")
#: which drive is spoilt
DRIVES = ("first", "second")
_TARGETS = {"slow": (0.06, -0.06), "fast": (0.9, -0.9)}
#: N m, of either drive a fifth of what it may ask for
_PUSHES_NM = (3.0, -1.2)
#: motions in which an axis becomes fast by itself
_ON_ITS_WAY = ("fast", "pushed")
#: how long is watched what comes of it, ticks
_AFTER = 500


@dataclass(frozen=True)
class Outcome:
    """What came of a row: why the motion was ended, ticks until it was, how far the axis went until it stood (or the
    look at it ended), how much faster it had become, and what the bus made of it.
    """

    make: str
    drive: str
    row: str
    motion: str
    cause: str
    ticks: int
    gone_rad: float
    gained_rad_s: float
    only_braked: bool

    @property
    def is_noticed(self) -> bool:
        return bool(self.cause)


def rig_of(make: str, folder: Path) -> AdapterRig:
    """Host, adapter and two simulated drives of a make, configured as `init` does it."""
    near, far = memory_buses()
    return mapped_rig(folder, near=near, far=far) if make == "dbc" else AdapterRig(make, near=near, far=far)


def geared(sample: AxisSample, by: float) -> AxisSample:
    """A sample of what turns so many times as far."""
    rate = None if sample.rate_rad_s is None else by * sample.rate_rad_s
    return replace(sample, position_rad=by * sample.position_rad, rate_rad_s=rate)


def spoilt(rig: AdapterRig, spoil: Spoil, before: Sequence[AxisSample], place: int = 0) -> None:
    """From now on the samples of the drive at this place are spoilt as the gateway takes them; how, is said of its
    joint, behind the gear.
    """
    gateway, start, gear = rig.gateway, rig.number, rig.settings.link.drives[place].gear
    old = tuple(geared(one, 1.0 / gear) for one in before)
    drive, since = gateway.drives[place], deque[AxisSample](maxlen=KEPT)
    follow, feedback, silent = gateway._advance, gateway.feedback, gateway.silent

    def wrong(do: Callable[..., object]) -> Callable[..., object]:
        def done(*given: object) -> object:
            true = drive.sample
            drive.sample = geared(spoil(Seen(geared(true, 1.0 / gear), rig.number - start, old, since)), gear)
            try:
                return do(*given)
            finally:
                drive.sample = true

        return done

    def told() -> object:
        since.append(geared(drive.sample, 1.0 / gear))
        return wrong(feedback)()

    gateway._advance, gateway.feedback, gateway.silent = wrong(follow), told, wrong(silent)


def moving(rig: AdapterRig, motion: str, place: int) -> list[AxisSample]:
    """The motion is under way; samples of the drive at this place until now."""
    rig.connected()
    if motion == "rest":
        rig.position(0.03, -0.03).run(500)
    elif motion == "pushed":
        rig.torque(*(push if axis == place else 0.0 for axis, push in enumerate(_PUSHES_NM)))
    else:
        rig.position(*_TARGETS[motion])
    before = []
    for _ in range(KEPT if motion != "pushed" else 60):
        rig.run(1)
        before.append(rig.gateway.drives[place].sample)
    return before


def outcome(rig: AdapterRig, make: str, drive: str, row: Row, motion: str) -> Outcome:
    """A fault of that drive while the axes move so, until half a second after it was noticed."""
    place = DRIVES.index(drive)

    def rate() -> float:
        return abs(float(rig.gimbal.plant.X[RATE + place]))

    before = moving(rig, motion, place)
    start, first = float(rig.joints[place]), rate()
    spoilt(rig, row.spoil, before, place)
    gone = gained = 0.0
    noticed, braked = None, True
    for tick in range(row.within + _AFTER):
        rig.run(1)
        gone = max(gone, abs(float(rig.joints[place]) - start))
        gained = max(gained, rate() - first)
        if noticed is None and rig.host.state is not HostState.ACTIVE:
            noticed = tick + 1
        if noticed is None and tick + 1 >= row.within:
            break
        if noticed is not None and tick > noticed + 20:
            # the loops, which brake before a limit, may push back what they overshot by
            braked = braked and (rig.only_brakes() or rig.host.state is HostState.STOPPING)
            if tick > noticed + _AFTER:
                break
    cause = "" if noticed is None else rig.host.cause.name
    return Outcome(make, drive, row.name, motion, cause, noticed or 0, gone, gained, braked)


def outcomes(makes: Sequence[str], known: Sequence[Outcome]) -> Iterator[Outcome]:
    """Each row in each motion that is not known, on a rig of its own."""
    done = {(one.make, one.drive, one.row, one.motion) for one in known}
    for make, drive, row, motion in itertools.product(makes, DRIVES, ROWS, MOTIONS):
        if (make, drive, row.name, motion) in done:
            continue
        with tempfile.TemporaryDirectory() as folder:
            rig = rig_of(make, Path(folder))
            try:
                yield outcome(rig, make, drive, row, motion)
            finally:
                rig.close()


def read(files: Sequence[Path]) -> list[Outcome]:
    """Outcomes, one a line."""
    return [Outcome(**json.loads(line)) for file in files if file.exists() for line in file.read_text().splitlines()]


def _table(found: Sequence[Outcome], drive: str) -> list[str]:
    cells = {(one.row, one.motion, one.make): one for one in found if one.drive == drive}
    makes = [make for make in MAKES if any(one.make == make for one in found)]
    lines = ["| fault of the feedback | " + " | ".join(MOTIONS) + " |", "|---|" + "---|" * len(MOTIONS)]
    alike: dict[tuple[str, ...], list[str]] = {}
    for row in ROWS:
        told = (_cell([cells[row.name, motion, make] for make in makes], motion in row.not_in) for motion in MOTIONS)
        alike.setdefault(tuple(told), []).append(row.name)
    return lines + [f"| {'; '.join(names)} | {' | '.join(told)} |" for told, names in alike.items()]


def page(found: Sequence[Outcome]) -> str:
    """The page of docs/measurements; outcomes of all makes."""
    tables = [["", f"## The {drive} drive is spoilt", "", *_table(found, drive)] for drive in DRIVES]
    impossible = [
        fill(f"- {row.name} ({', '.join(row.not_in)}): {row.reason}.", 120, subsequent_indent="  ")
        for row in ROWS
        if row.not_in
    ]
    asked = [one for one in found if one.motion not in _row(one.row).not_in]
    held = [one for one in found if one.motion not in _ON_ITS_WAY]
    worst = max(held, key=lambda one: one.gained_rad_s)
    noticed = sum(one.is_noticed and one.only_braked for one in asked)
    return _PAGE.format(
        noticed=noticed,
        asked=len(asked),
        unasked=len(found) - len(asked),
        makes=", ".join(make for make in MAKES if any(one.make == make for one in found)),
        impossible="\n".join(impossible),
        fastest=worst.gained_rad_s,
        worst=worst.row,
        else_fastest=max(one.gained_rad_s for one in held if one.row != worst.row),
        tables="\n".join(itertools.chain(*tables)),
    )


_PAGE = """# Faults of feedback behind drives of other makes

Made by `python -m tests.adapters.faults --page`; do not edit. Two simulated drives of a make move the gimbal that
`init` describes, with the configuration that `init` writes for hardware, at 1 kHz, tick by tick. What the adapter hears
of one drive is spoilt: of the one that carries (first) or of the one that is carried (second). Meanwhile the axes are
held (rest), move to 0.06 rad (slow) or 0.9 rad (fast), or that drive is pushed by a fifth of its torque, 3 or 1.2 N m
(pushed). The size of a fault is that at the joint, behind the gear.

**{noticed} of {asked} noticed**, and afterwards no drive had torque but against its own motion; {unasked} more need not
be noticed, because nobody who has these numbers only can tell them from what a sound antenna does:

{impossible}

A cell tells the cause, the time until it was told, and how far the axis went in all until half a second later, coasting
included. Ranges are those over {makes}. Faults with the same cells share a row.
A moteus shorts its winding, the others let go and friction stops the axis ([adapters](../reference/adapters.md)).
A dash: not noticed, the way is that of the whole time that was watched. `OVERSPEED` and `TRAVEL` say nothing of the
feedback: they end a push as they do where it is true. An axis that was held or moved slowly became faster by
{fastest:.2g} rad/s at most ({worst}), else by {else_fastest:.2g} rad/s.
{tables}
"""


def _row(name: str) -> Row:
    return next(row for row in ROWS if row.name == name)


def _cell(makes: Sequence[Outcome], is_impossible: bool) -> str:
    """What all makes tell of one fault in one motion; what only some of them do stands beside its make."""
    way = f"{_range([f'{one.gone_rad:.2g}' for one in makes])} rad"
    if not any(one.is_noticed for one in makes):
        return f"{'as true' if is_impossible else '**-**'}, {way}"
    causes = {one.cause: [other.make for other in makes if other.cause == one.cause] for one in makes}
    told = [
        (f"`{cause}`" if cause else "**-**") + ("" if len(of) == len(makes) else f" ({', '.join(of)})")
        for cause, of in causes.items()
    ]
    driven = [one.make for one in makes if one.is_noticed and not one.only_braked]
    ticks = _range([str(one.ticks) for one in makes if one.is_noticed])
    on = f", **driven on** ({', '.join(driven)})" if driven else ""
    return f"{' or '.join(told)}, {ticks} ms, {way}{on}"


def _range(figures: Sequence[str]) -> str:
    """The least and the most of written figures, once where they are the same."""
    return "-".join(dict.fromkeys(sorted((min(figures, key=float), max(figures, key=float)), key=float)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("makes", nargs="*", help=", ".join(MAKES))
    parser.add_argument("--out", type=Path)
    parser.add_argument("--seconds", type=float, default=math.inf)
    parser.add_argument("--page", type=Path, nargs="+", help="files that --out wrote")
    given = parser.parse_args()
    if given.page:
        print(page(read(given.page)), end="")
        return
    end = time.monotonic() + given.seconds
    known = [] if given.out is None else read([given.out])
    for found in outcomes(given.makes or MAKES, known):
        print(found, flush=True)
        if given.out is not None:
            with given.out.open("a") as out:
                out.write(json.dumps(asdict(found)) + "\n")
        if time.monotonic() > end:
            return


if __name__ == "__main__":
    main()
