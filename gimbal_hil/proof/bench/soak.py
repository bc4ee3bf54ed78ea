"""`gimbal-hil bench soak`: a day of antenna time in lockstep, random commands, one frame in a hundred damaged, lost or
late; whether every tick is accounted for and memory stays as it is.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import os
import random
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.schema import RECORD_SIZE
from gimbal_hil.data.runs import TICK_ROW, EventKind, Retention, RunHeader, RunWriter, read_header
from gimbal_hil.loop.host import (
    MEASURED,
    ROW_WORDS,
    ROWS_KEPT,
    AxisCommand,
    EventCode,
    Host,
    HostState,
    Mode,
    Program,
    ReferenceOrigin,
    Segment,
    Shape,
    program_of,
    word_of,
)
from gimbal_hil.loop.settings import DaemonSettings, host_configuration
from sim_backend.device import Device
from sim_backend.model import AntennaModel

#: share of frames that suffer something, share of memory that may be gained after the first hour
FAULTS, MEMORY_SHARE = 0.01, 0.02
#: no joint is ever faster (rad/s): the drive's own limit is 18
_FASTEST_RAD_S = 18.5
_TORQUE_STATES = (HostState.ACTIVE, HostState.STOPPING)
#: how a line of the text begins that says what was wrong
WRONG = "WRONG: "


@dataclass
class SoakFigures:
    """What was seen; `problems` is empty when all was right."""

    antenna_h: float = 0.0
    wall_s: float = 0.0
    ticks: int = 0
    rows: int = 0
    recorded: int = 0
    frames: int = 0
    frames_hurt: int = 0
    commands: dict[str, int] = field(default_factory=dict)
    faults_of_host: dict[str, int] = field(default_factory=dict)
    fastest_rad_s: float = 0.0
    #: resident memory after each hour of antenna time, MiB
    memory_mb: list[float] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)

    @property
    def memory_gained(self) -> float:
        """Share of memory that the last hour has more than the first."""
        return self.memory_mb[-1] / self.memory_mb[0] - 1.0 if self.memory_mb else 0.0


class HurtLine:
    """Passes blocks on; one frame in a hundred is lost, doubled, damaged or a tick late, by seed."""

    def __init__(self, seed: int, share: float = FAULTS) -> None:
        self._random, self._share = random.Random(seed), share
        self._late = b""
        self.frames = self.hurt = 0
        self._left = self._gap()

    def pass_on(self, block: bytes) -> bytes:
        """What arrives of a block at this tick."""
        count = len(block) // RECORD_SIZE
        self.frames += count
        if count < self._left and not self._late:
            self._left -= count
            return block
        arriving, self._late = bytearray(self._late), b""
        for at in range(0, len(block), RECORD_SIZE):
            record = block[at : at + RECORD_SIZE]
            self._left -= 1
            if self._left > 0:
                arriving += record
            else:
                self._left = self._gap()
                arriving += self._hurt(record)
        return bytes(arriving)

    def _hurt(self, record: bytes) -> bytes:
        self.hurt += 1
        kind = self._random.randrange(4)
        if kind == 0:
            return b""
        if kind == 1:
            return record + record
        if kind == 2:
            damaged = bytearray(record)
            damaged[self._random.randrange(RECORD_SIZE)] ^= 1 << self._random.randrange(8)
            return bytes(damaged)
        self._late += record
        return b""

    def _gap(self) -> int:
        return 1 + int(self._random.expovariate(self._share))


def soak(
    settings: DaemonSettings,
    model: AntennaModel,
    hours: float,
    seed: int = 0,
    say: Callable[[str], None] = lambda text: None,
) -> SoakFigures:
    """Run for `hours` of antenna time, recording into a folder that keeps the newest 32 MiB."""
    figures, began = SoakFigures(), time.monotonic()
    host, device = Host(host_configuration(settings)), Device(model, rate_hz=settings.rate_hz, seed=seed)
    lines, draw = (HurtLine(seed), HurtLine(seed + 1)), random.Random(seed + 2)
    step_ns, hour_ticks = round(1e9 / settings.rate_hz), round(3600 * settings.rate_hz)
    ticks = round(hours * hour_ticks)
    answer, asked_at = b"", 100
    with tempfile.TemporaryDirectory() as folder:
        header = RunHeader(settings.model_dump(mode="json", by_alias=True), model.document, seed, step_ns, True, "soak")
        with RunWriter(Path(folder), header, retention=Retention(segment_mb=8.0, keep_mb=32.0)) as writer:
            for tick in range(ticks):
                if tick == asked_at:
                    asked_at += _ask(host, draw, figures, settings.rate_hz)
                sent = host.tick(tick, tick * step_ns, lines[0].pass_on(answer))
                answer = device.tick(lines[1].pass_on(sent))
                if tick % ROWS_KEPT == ROWS_KEPT - 1 or tick == ticks - 1:
                    _account(host, tick, step_ns, writer, figures, settings)
                if tick % hour_ticks == hour_ticks - 1:
                    figures.memory_mb.append(_memory_mb())
                    say(f"{(tick + 1) // hour_ticks} h of {hours:g}, {figures.memory_mb[-1]:.1f} MiB")
        end = read_header(Path(folder)).end
        figures.recorded = end.counts["ticks"] if end else 0
    figures.ticks, figures.antenna_h, figures.wall_s = device.ticks, hours, time.monotonic() - began
    figures.frames, figures.frames_hurt = (sum(getattr(line, what) for line in lines) for what in ("frames", "hurt"))
    if not figures.ticks == figures.rows == figures.recorded == ticks:
        figures.problems.append(f"{ticks} ticks, {figures.rows} rows, {figures.recorded} recorded")
    if abs(figures.memory_gained) > MEMORY_SHARE:
        figures.problems.append(f"memory changed by {figures.memory_gained:.1%}")
    return figures


def soak_text(figures: SoakFigures) -> str:
    """For people."""
    memory = "less than an hour ran"
    if figures.memory_mb:
        first, last = figures.memory_mb[0], figures.memory_mb[-1]
        memory = f"{first:.1f} MiB after the first hour, {last:.1f} after the last ({figures.memory_gained:+.2%})"
    counts = ", ".join(f"{count} {name}" for name, count in sorted(figures.commands.items()))
    faults = ", ".join(f"{count} {name}" for name, count in sorted(figures.faults_of_host.items()))
    hurt = f"{figures.frames_hurt} of {figures.frames} frames damaged ({figures.frames_hurt / figures.frames:.2%})"
    lines = [
        f"{figures.antenna_h:g} h of antenna time in {figures.wall_s:.0f} s: {figures.ticks} ticks,"
        f" {figures.rows} rows, {figures.recorded} recorded",
        f"{hurt}; asked: {counts}; faults: {faults or 'none'}; fastest {figures.fastest_rad_s:.2f} rad/s",
        f"memory: {memory}",
    ]
    return "\n".join([*lines, *(f"{WRONG}{problem}" for problem in figures.problems or ())])


def _ask(host: Host, draw: random.Random, figures: SoakFigures, rate_hz: float) -> int:
    """One command of an operator who knows no rest; answers after how many ticks comes the next."""
    if host.state is HostState.FAULT:
        name = "reset"
        host.reset_fault()
    else:
        name = draw.choices(("program", "stop", "quick_stop"), (0.85, 0.1, 0.05))[0]
        if name == "program":
            host.command(random_program(draw, rate_hz))
        else:
            getattr(host, name)()
    figures.commands[name] = figures.commands.get(name, 0) + 1
    return 1 + int(draw.expovariate(1.0 / (2.0 * rate_hz)))


def random_program(draw: random.Random, rate_hz: float) -> Program:
    """One to three segments in any modes and shapes."""
    return program_of(
        [
            Segment(
                _axis(draw, (3.0, 3.0, 3.0)),
                _axis(draw, (1.5, 2.0, 1.0)),
                round(draw.uniform(0.1, 4.0) * rate_hz),
                label=label,
                switch_off_afterwards=draw.random() < 0.3,
            )
            for label in range(draw.randrange(1, 4))
        ]
    )


def _axis(draw: random.Random, most: tuple[float, float, float]) -> AxisCommand:
    """Positions (rad), rates (rad/s) and torques (N m) up to `most`, in any shape that has an end."""
    mode = draw.choice((Mode.OFF, Mode.POSITION, Mode.POSITION, Mode.RATE, Mode.INERTIAL_RATE, Mode.TORQUE))
    size = most[{Mode.POSITION: 0, Mode.TORQUE: 2}.get(mode, 1)]
    value, swing = draw.uniform(-size, size), draw.uniform(0.0, 0.5 * size)
    shape, parameters = draw.choice(
        (
            (Shape.HOLD, (value,)),
            (Shape.SINE, (0.0, swing, draw.uniform(0.1, 3.0), 0.0)),
            (Shape.SMOOTH, (value, draw.uniform(0.5, 3.0))),
            (Shape.TRAPEZOID, (value, draw.uniform(0.5, 3.0), draw.uniform(1.0, 10.0))),
            (Shape.CHIRP, (0.0, 0.2 * swing, 0.5, 1.0, 3.0)),
        )
    )
    origin = draw.choice(tuple(ReferenceOrigin)) if mode is not Mode.TORQUE else ReferenceOrigin.ABSOLUTE
    return AxisCommand(mode, shape, parameters, origin)


def _account(
    host: Host, tick: int, step_ns: int, writer: RunWriter, figures: SoakFigures, settings: DaemonSettings
) -> None:
    """Take the rows since the last call, look at each, and record them."""
    log = host.take_log()
    rows = np.ascontiguousarray(log[:, :ROW_WORDS]).reshape(-1).view(TICK_ROW)
    if not np.array_equal(rows["tick"], np.arange(figures.rows, figures.rows + len(rows))):
        figures.problems.append(f"rows before tick {tick} are not its own")
    figures.rows += len(rows)
    limits = [axis.limits.torque_nm for axis in settings.axes.values()]
    figures.problems += [f"{problem}, before tick {tick}" for problem in torque_problems(rows, limits)]
    fastest = float(np.abs(log.view(np.float64)[:, MEASURED + 2 : MEASURED + 4]).max())
    figures.fastest_rad_s = max(figures.fastest_rad_s, fastest)
    if fastest > _FASTEST_RAD_S:
        figures.problems.append(f"{fastest:.1f} rad/s before tick {tick}")
    for event in host.events():
        if event.code is EventCode.STATE and event.data["to"] == word_of(HostState.FAULT):
            cause = str(event.data["cause"])
            figures.faults_of_host[cause] = figures.faults_of_host.get(cause, 0) + 1
        writer.event(event.tick, event.tick * step_ns, EventKind.NOTE, event.text, event.data)
    writer.append_ticks(rows)


def torque_problems(rows: NDArray[np.void], limits_nm: list[float]) -> list[str]:
    """What is wrong with the torques of tick rows: in a state without torque, or beyond the axes' limits."""
    torque = np.abs(np.stack([rows["torque_outer"], rows["torque_inner"]]))
    problems = []
    if torque[:, ~np.isin(rows["host_state"], [int(state) for state in _TORQUE_STATES])].any():
        problems.append("torque in a state without torque")
    if (torque.max(axis=1) > np.array(limits_nm) + 1e-9).any():
        problems.append(f"torques of {torque.max(axis=1)} N m")
    return problems


def _memory_mb() -> float:
    """Resident memory of what is in use: what the allocator keeps for later goes back to the machine first."""
    gc.collect()
    with contextlib.suppress(OSError, AttributeError):
        # glibc only
        ctypes.CDLL(None).malloc_trim(0)
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / (1 << 20)
