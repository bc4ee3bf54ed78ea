"""The fault matrix run: each row on a fresh antenna, judged against its bounds."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import closing
from dataclasses import asdict, dataclass

import numpy as np

from firmware_protocol.enumerations import DriveState
from gimbal_hil.loop.host import AxisCommand, HostState, Mode, Program, ReferenceOrigin, Segment, Shape, program_of
from gimbal_hil.loop.settings import DaemonSettings
from gimbal_hil.proof.bench.faults.rig import Rig, Transport
from gimbal_hil.proof.bench.faults.rows import SPEED_RAD_S, FaultRow, Motion
from sim_backend.firmware_run import FirmwareRun
from sim_backend.model import AntennaModel

#: how long an antenna is looked at after the fault, and how much faster it may get from one that changes nothing
_LOOK_S, _UNSEEN_RAD_S = 4.0, 0.1


@dataclass(frozen=True)
class FaultOutcome:
    """What came of a row: seconds until the drive stopped by itself or by request (None: it did not), until rest, and
    how far and fast.
    """

    row: FaultRow
    transport: Transport
    cause: str
    safe_s: float | None
    rest_s: float | None
    excess_rad_s: float
    travel_rad: float
    recorded: bool
    problem: str

    def as_dict(self) -> dict[str, object]:
        """For JSON."""
        found = {key: value for key, value in asdict(self).items() if key != "row"}
        bounds = {"safe_s": self.row.safe_s, "excess_rad_s": self.row.excess_rad_s, "travel_rad": self.row.travel_rad}
        return {"name": self.row.name, **found, "transport": str(self.transport), "bounds": bounds}


def run_matrix(
    rows: Iterable[FaultRow],
    settings: DaemonSettings,
    model: AntennaModel,
    say: Callable[[str], None] = lambda name: None,
    firmware: FirmwareRun = FirmwareRun.VIRTUAL,
) -> list[FaultOutcome]:
    """Every row on every transport, against this firmware."""
    found = []
    for row in rows:
        say(row.name)
        found += [run_row(row, settings, model, transport, firmware) for transport in Transport]
    return found


def run_row(
    row: FaultRow,
    settings: DaemonSettings,
    model: AntennaModel,
    transport: Transport,
    firmware: FirmwareRun = FirmwareRun.VIRTUAL,
) -> FaultOutcome:
    """One row: connect, move, fault, look."""
    with closing(Rig(settings, model, transport, 7, firmware)) as rig:
        return _outcome(rig, row, settings, transport)


def _outcome(rig: Rig, row: FaultRow, settings: DaemonSettings, transport: Transport) -> FaultOutcome:
    rig.advance(60)
    rig.host.command(_motion(row))
    rig.advance(round((0.3 if row.motion is Motion.REST else 0.8) * settings.rate_hz))
    began = rig.tick
    if rig.host.state is not HostState.ACTIVE:
        return FaultOutcome(
            row, transport, rig.host.cause.name.lower(), None, None, 0.0, 0.0, False, "tripped before the fault came"
        )
    start, before = np.array(rig.device.joint_positions), np.abs(rig.device.joint_rates).max()
    rig.suffer(row)
    motions, safe = [], None
    for tick in range(round(_LOOK_S * settings.rate_hz)):
        motions.append(rig.advance(1))
        if safe is None and rig.device.state is not DriveState.OPERATION_ENABLED:
            safe = (tick + 1) / settings.rate_hz
    motion = np.concatenate(motions)
    rates = np.abs(motion[:, 2:]).max(axis=1)
    moving = np.flatnonzero(rates > row.rest_rad_s)
    rest = 0.0 if not len(moving) else (None if moving[-1] == len(rates) - 1 else (moving[-1] + 1) / settings.rate_hz)
    outcome = FaultOutcome(
        row,
        transport,
        _cause(rig),
        safe,
        rest,
        float(max(rates.max() - max(before, SPEED_RAD_S[row.motion]), 0.0)),
        float(np.abs(motion[:, :2] - start).max()),
        rig.host.row != b"" and any(event.tick >= began for event in rig.events),
        "",
    )
    return FaultOutcome(**{**vars(outcome), "problem": _problem(outcome)})


def _motion(row: FaultRow) -> Program:
    hold = AxisCommand(Mode.POSITION, Shape.HOLD, (0.0,), ReferenceOrigin.START)
    speed = SPEED_RAD_S[row.motion] * (1.0 if row.axis == 0 else -1.0)
    moving = AxisCommand(Mode.RATE, Shape.HOLD, (speed,)) if row.motion is not Motion.REST else hold
    if row.axis == 1 and row.motion is Motion.FAST:
        # within its travel: to and fro
        moving = AxisCommand(Mode.RATE, Shape.SINE, (0.0, 3.0, 0.6, -1.5))
    return program_of([Segment(moving if row.axis == 0 else hold, moving if row.axis == 1 else hold)])


def _cause(rig: Rig) -> str:
    if rig.host.state is HostState.FAULT:
        return str(rig.host.cause.name.lower())
    return f"drive: {rig.device.fault.name.lower()}" if rig.device.fault else "nothing"


def _problem(found: FaultOutcome) -> str:
    """Which bound was broken, empty when all held."""
    row = found.row
    if found.safe_s is None:
        unseen = row.may_pass and found.excess_rad_s <= _UNSEEN_RAD_S
        return "" if unseen else "nothing stopped it"
    if found.safe_s > row.safe_s and not row.may_pass:
        return f"safe after {found.safe_s:.3f} s"
    if found.excess_rad_s > row.excess_rad_s:
        return f"{found.excess_rad_s:.2f} rad/s faster than before"
    if found.travel_rad > row.travel_rad and not row.may_pass:
        return f"{found.travel_rad:.2f} rad travelled"
    if found.rest_s is None:
        return "did not come to rest"
    return "" if found.recorded else "nothing was recorded of it"
