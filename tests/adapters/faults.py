"""What can be wrong with the feedback of a drive of another make, and what comes of it: rows of one matrix.

What is spoilt is what an adapter last heard, so that every row holds for every make. `python -m tests.adapters.faults
MAKE... --out FILE` adds the outcomes that are not in FILE yet, `--seconds` at most; `--page FILE...` prints the page.
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

from firmware_protocol.adapters import AxisSample, Power
from gimbal_hil.loop.host import HostState
from sim_backend.layout import RATE
from tests.adapters.rig import AdapterRig, memory_buses
from tests.adapters.servo import mapped_rig

MAKES = ("moteus", "odrive", "cia402", "dbc")
#: which drive is spoilt
DRIVES = ("first", "second")
#: an axis that is held, moves slowly and fast to a position, and is pushed by a torque
MOTIONS = ("rest", "slow", "fast", "pushed")
_TURN = 2.0 * math.pi
#: samples from before the fault that are kept, one a tick
_KEPT = 100


@dataclass(frozen=True)
class Seen:
    """What a spoiler may use: the true sample, ticks since the fault began, samples from before it, oldest first, and
    what a link that is late has still to give.
    """

    now: AxisSample
    ticks: int
    before: Sequence[AxisSample]
    since: Sequence[AxisSample]

    @property
    def then(self) -> AxisSample:
        return self.before[-1]


Spoil = Callable[[Seen], AxisSample]


@dataclass(frozen=True)
class Row:
    """A fault of feedback; within how many ticks it is noticed, and why it need not be in some motions; how far (rad)
    an axis may go, on its own way until then and coasting after it.
    """

    name: str
    spoil: Spoil
    within: int
    not_in: tuple[str, ...] = ()
    reason: str = ""
    gone_rad: float = 5.0


def _shifted(by_rad: float) -> Spoil:
    return lambda seen: replace(seen.now, position_rad=seen.now.position_rad + by_rad)


def _frozen(seen: Seen) -> AxisSample:
    return replace(seen.then, updates=seen.now.updates, power=seen.now.power, power_updates=seen.now.power_updates)


def _stuck_and_moving(seen: Seen) -> AxisSample:
    return replace(seen.now, position_rad=seen.then.position_rad, rate_rad_s=1.0)


def _repeated(seen: Seen) -> AxisSample:
    old = seen.before[seen.ticks % len(seen.before)]
    return replace(old, updates=seen.now.updates, power=seen.now.power, power_updates=seen.now.power_updates)


def _restarted(seen: Seen) -> AxisSample:
    """Off for 50 ms, then as before with its zero where it stood."""
    power = Power.OFF if seen.ticks < 50 else seen.now.power
    return replace(seen.now, position_rad=seen.now.position_rad - seen.then.position_rad + 0.3, power=power)


def _silent_then_a_turn_off(seen: Seen) -> AxisSample:
    if seen.ticks < 1000:
        return replace(seen.then, power=seen.now.power)
    return replace(seen.now, position_rad=seen.now.position_rad - _TURN)


def _late(ticks: int) -> Spoil:
    def old(seen: Seen) -> AxisSample:
        whole = (*seen.before, *seen.since)
        now = seen.now
        return replace(whole[-ticks], updates=now.updates, power=now.power, power_updates=now.power_updates)

    return old


def _still_but_for_noise(seen: Seen) -> AxisSample:
    """A sensor that has come loose, with the noise that it had: 10 urad, 1 mrad/s."""
    place = seen.then.position_rad + 1e-5 * math.sin(seen.ticks**1.3)
    return replace(seen.now, position_rad=place, rate_rad_s=1e-3 * math.sin(seen.ticks**1.7))


def _halved(seen: Seen) -> AxisSample:
    """As of a gear of twice its turns."""
    moved = seen.now.position_rad - seen.then.position_rad
    half = 0.5 * (seen.now.rate_rad_s or 0.0)
    return replace(seen.now, position_rad=seen.then.position_rad + 0.5 * moved, rate_rad_s=half)


def _creeping_alike(seen: Seen) -> AxisSample:
    rate = 0.1 + (seen.now.rate_rad_s or 0.0)
    return replace(seen.now, position_rad=seen.now.position_rad + 1e-4 * seen.ticks, rate_rad_s=rate)


def _slower(seen: Seen) -> AxisSample:
    return replace(seen.now, rate_rad_s=0.5 * (seen.now.rate_rad_s or 0.0))


_HUNTING = "the loops hold an axis so, with a swing that any lag in them makes"
_NO_WAY = "the axis hardly moves, and half of no rate is none"
_HEAVY = (
    "two numbers of one sensor agree, and an axis of twice the inertia moves so: `expectation` allows for half of it"
)
_LOAD = (
    "a load that grows with the torque holds an axis so; `expectation.disturbance_nm` says how large one may be, and "
    "`init` writes 30 % of the torque"
)
_STEP = "a coarse encoder makes such steps, up to 0.05 rad"
_STILL = "true feedback of an axis that stands still is the same, until a loop asks for more torque than may hold it"
ROWS = (
    Row("all of it stands still", _frozen, 1200),
    Row(
        "the position stands still, the rate is true",
        lambda seen: replace(seen.now, position_rad=seen.then.position_rad),
        1500,
        ("rest",),
        _STILL,
    ),
    Row("the position stands still, the rate says 1 rad/s", _stuck_and_moving, 600),
    Row(
        "the rate stands still, the position is true",
        lambda seen: replace(seen.now, rate_rad_s=seen.then.rate_rad_s),
        2500,
    ),
    Row("the rate has the wrong sign", lambda seen: replace(seen.now, rate_rad_s=-(seen.now.rate_rad_s or 0.0)), 1500),
    Row(
        "position and rate have the wrong sign",
        lambda seen: replace(
            seen.now,
            position_rad=2 * seen.then.position_rad - seen.now.position_rad,
            rate_rad_s=-(seen.now.rate_rad_s or 0.0),
        ),
        1500,
    ),
    Row(
        "the position creeps, the rate says rest",
        lambda seen: replace(seen.now, position_rad=seen.now.position_rad + 2e-4 * seen.ticks),
        1500,
    ),
    Row(
        "position and rate creep alike",
        _creeping_alike,
        1200,
        ("rest", "slow", "fast"),
        "two numbers of one sensor agree, and the axis does what they say: only a second sensor can tell",
    ),
    Row("samples of 0.1 s repeat themselves for ever", _repeated, 1500),
    Row("every sample is 60 ms late", _late(60), 1500),
    Row("every sample is 20 ms late", _late(20), 1500, MOTIONS, _HUNTING),
    Row("the rate is half of what it was", _slower, 1500, ("rest", "slow"), _NO_WAY),
    Row("position and rate are half of what they were", _halved, 1500, ("rest", "slow"), _HEAVY, 20.0),
    Row("it stands still but for its noise", _still_but_for_noise, 1500, ("rest",), _LOAD, 35.0),
    Row(
        "the position creeps by 0.04 rad/s, the rate says rest",
        lambda seen: replace(seen.now, position_rad=seen.now.position_rad + 4e-5 * seen.ticks),
        6000,
    ),
    Row("the position jumps by 2 degrees", _shifted(math.radians(2.0)), 500, MOTIONS, _STEP),
    Row("the drive restarts and its zero is lost", _restarted, 100),
    Row("the position jumps by 18 degrees", _shifted(math.radians(18.0)), 5),
    Row(
        "one sample in fifty is 1 rad off",
        lambda seen: replace(seen.now, position_rad=seen.now.position_rad + (seen.ticks % 50 == 0)),
        55,
    ),
    Row("a whole turn is lost", _shifted(-_TURN), 5),
    Row("a whole turn is lost in a silence of a second", _silent_then_a_turn_off, 1100),
    Row("the position is nine turns off", _shifted(9 * _TURN), 5),
    Row("a count of 32 bits wraps", _shifted(-(2**32) / 2**14 * _TURN), 5),
    Row("the position is no number", lambda seen: replace(seen.now, position_rad=math.nan), 5),
    Row("the rate is beyond all reason", lambda seen: replace(seen.now, rate_rad_s=1e6), 5),
    Row("the rate is no number", lambda seen: replace(seen.now, rate_rad_s=math.nan), 5),
)
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
    drive, since = gateway.drives[place], deque[AxisSample](maxlen=_KEPT)
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
    for _ in range(_KEPT if motion != "pushed" else 60):
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
