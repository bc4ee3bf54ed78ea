"""Real runs made quickly: the host core against the virtual antenna in lockstep, with faults of the link on request."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gimbal_hil.data.runs import TICK_ROW, EventKind, RunHeader, RunWriter
from gimbal_hil.loop.host import AxisCommand, Host, HostState, Mode, Segment, Shape, program_of
from gimbal_hil.loop.settings import host_configuration, shipped_settings
from sim_backend.device import Device
from sim_backend.model import shipped_model

PERIOD_NS = 1_000_000
SEED = 3


class WireFaults:
    """Between host and device: loses, repeats, flips bits, and is cut for a while; by seed."""

    def __init__(self, seed: int, rate: float, cuts: tuple[tuple[int, int], ...] = ()) -> None:
        self._random, self._rate, self._cuts = np.random.default_rng(seed), rate, cuts

    def pass_on(self, tick: int, block: bytes) -> bytes:
        """The block as the other end receives it."""
        if any(start <= tick < end for start, end in self._cuts):
            return b""
        if self._random.random() >= self._rate or not block:
            return block
        records = [block[at : at + 10] for at in range(0, len(block), 10)]
        victim, kind = int(self._random.integers(len(records))), int(self._random.integers(3))
        if kind == 0:
            records.pop(victim)
        elif kind == 1:
            records.insert(victim, records[victim])
        else:
            damaged = bytearray(records[victim])
            damaged[int(self._random.integers(10))] ^= 1 << int(self._random.integers(8))
            records[victim] = bytes(damaged)
        return b"".join(records)


def record_lockstep(
    folder: Path,
    ticks: int,
    *,
    faults: WireFaults | None = None,
    stalls: dict[int, int] | None = None,
    force: bool = False,
) -> Host:
    """Position steps, a rate sine and a torque on both axes; at `stalls` the host loses whole periods while the device
    goes on.
    """
    settings = shipped_settings()
    host, device = Host(host_configuration(settings)), Device(shipped_model(), seed=SEED)
    header = RunHeader(
        settings.model_dump(mode="json", by_alias=True), {"name": "thesis"}, SEED, PERIOD_NS, lockstep=True
    )
    writer = RunWriter(folder, header, force=force)
    wire = faults or WireFaults(0, 0.0)
    sine = AxisCommand(Mode.RATE, Shape.SINE, (0.0, 0.3, 2.0, 0.0))
    step = AxisCommand(Mode.POSITION, Shape.HOLD, (0.2,))
    programs = [
        program_of(
            [
                Segment(step, step, duration_ticks=700, label=1),
                Segment(sine, AxisCommand(Mode.TORQUE, parameters=(0.05,)), label=2),
            ]
        ),
        program_of([Segment(AxisCommand(Mode.INERTIAL_RATE, parameters=(0.1 + 0.2,)), step, label=3)]),
    ]
    answer = device.tick()
    tick = given = 0
    while tick < ticks:
        skipped = (stalls or {}).get(tick, 0)
        for number in range(tick, tick + skipped):
            answer += wire.pass_on(number, device.tick())
        tick += skipped
        if host.state is HostState.IDLE and given < len(programs) and tick > 400 + 1500 * given:
            host.command(programs[given])
            writer.command(
                tick, tick * PERIOD_NS, "start", {"command": "start", "program": programs[given].as_document()}
            )
            given += 1
        if tick == 1700:
            host.stop()
            writer.command(tick, tick * PERIOD_NS, "stop", {"command": "stop"})
        sent = host.tick(tick, tick * PERIOD_NS, answer)
        writer.append_exchange(tick, answer, sent)
        writer.append_ticks(np.frombuffer(host.row, TICK_ROW))
        for event in host.events():
            writer.event(event.tick, event.tick * PERIOD_NS, EventKind.STATE, event.text, event.data)
        answer = wire.pass_on(tick, device.tick(wire.pass_on(tick, sent)))
        tick += 1
    writer.close()
    return host
