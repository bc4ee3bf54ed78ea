"""Runs made through the writer without a host core: a small, exact stand-in for what a daemon records."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.block_codec import encode_messages, new_counters, new_mail
from firmware_protocol.enumerations import DriveState
from firmware_protocol.schema import BY_NAME, INDEX, offset
from gimbal_hil.data.runs import RunHeader, RunWriter, tick_rows

CONFIGURATION = {"rate_hz": 1000, "gains": {"kp": 2.5e-5}}
HEADER = RunHeader(CONFIGURATION, model={"name": "made up"}, seed=7, period_ns=1_000_000, lockstep=True)


class Sender:
    """One end of a link: physical values in, blocks of good frames out."""

    def __init__(self) -> None:
        self._mail, self._counters, self._out = new_mail(), new_counters(), np.zeros(200, np.uint8)

    def block(self, **messages: dict[str, float]) -> bytes:
        """The named messages in order as one block."""
        for name, values in messages.items():
            for place, field in enumerate(BY_NAME[name].fields, 1):
                self._mail[offset(name) + place] = round(values.get(field.name, 0) / field.step)
        order = np.array([INDEX[name] for name in messages], np.int64)
        return self._out[: encode_messages(self._mail, order, self._counters, self._out)].tobytes()


def torque_nm(tick: int | NDArray[np.int64]) -> NDArray[np.float64]:
    """Torque of the outer axis that the made-up host commands at a tick: a whole number of wire steps."""
    return np.round(2000 * np.sin(np.asarray(tick) / 50)) * 0.125e-3


def position_rad(tick: int | NDArray[np.int64]) -> NDArray[np.float64]:
    """Position of the outer axis sampled at a tick."""
    return 0.3 * np.sin(np.asarray(tick) / 200)


def yaw_rad(tick: int | NDArray[np.int64]) -> NDArray[np.float64]:
    """Heading of the base at a tick, on through half a turn."""
    return 2.9 + np.asarray(tick) * 1e-3


def device_block(device: Sender, tick: int, last_sequence: int, device_tick: int | None = None) -> bytes:
    """The feedback set of a tick, with base and motor frames at their rates."""
    number = tick if device_tick is None else device_tick
    messages: dict[str, dict[str, float]] = {}
    if number % 10 == 0:
        yaw = float(np.remainder(yaw_rad(number) + np.pi, 2 * np.pi) - np.pi)
        messages["base_attitude"] = {"roll": 0.01 * np.sin(number / 300), "set": number % 16}
        messages["base_heading"] = {"yaw": yaw, "valid_tick": number % 4096}
        messages["base_rate"] = {"r": 1.0}
    if number % 50 == 0:
        messages["motor_status_outer"] = {"torque": 0.1, "temperature": 20 + number * 1e-3, "supply": 28}
        messages["motor_status_inner"] = {"torque": 0.1, "temperature": 25, "supply": 28}
    messages["feedback_outer"] = {
        "position": float(position_rad(number)),
        "rate": float(0.3 / 0.2 * np.cos(number / 200)),
    }
    messages["feedback_inner"] = {"position": 0.1, "rate": 0.0}
    status = {
        "state": DriveState.OPERATION_ENABLED,
        "last_sequence": last_sequence % 1024,
        "deadman_margin": 5,
        "tick": number % 4096,
    }
    messages["drive_status"] = status
    return device.block(**messages)


def host_block(host: Sender, tick: int) -> bytes:
    """The set-point of a tick."""
    torque = {"torque_outer": float(torque_nm(tick)), "torque_inner": -0.25}
    return host.block(set_point=torque | {"sequence": tick % 1024, "enable_outer": 1, "enable_inner": 1})


def row_of(tick: int, skipped: int = 0) -> NDArray[np.void]:
    """The tick row of the made-up host."""
    row = tick_rows(1)
    row["tick"], row["time_ns"], row["skipped_ticks"], row["segment"] = tick, tick * 1_000_000, skipped, tick // 1000
    row["torque_outer"], row["torque_inner"] = torque_nm(tick), -0.25
    row["rate_ref_outer"], row["wake_latency_ns"] = 1.5, 40_000 + tick % 7
    return row


def record_run(
    folder: Path,
    ticks: int,
    *,
    close: bool = True,
    flush_every: int = 0,
    row: Callable[[int], NDArray[np.void]] = row_of,
    header: RunHeader = HEADER,
) -> RunWriter:
    """Record a made-up lockstep run; a flush every so many ticks, or when the writer sees fit."""
    writer = RunWriter(folder, header, clock_ns=lambda: 0)
    host, device = Sender(), Sender()
    for tick in range(ticks):
        if tick % 1000 == 0:
            writer.command(
                tick, tick * 1_000_000, "segment", {"mode": "torque", "number": tick // 1000, "value": 0.1 + 0.2}
            )
        writer.append_exchange(tick, device_block(device, tick, tick - 1), host_block(host, tick))
        writer.append_ticks(row(tick))
        if flush_every and tick % flush_every == flush_every - 1:
            writer.flush()
    if close:
        writer.close(0, "done")
    return writer
