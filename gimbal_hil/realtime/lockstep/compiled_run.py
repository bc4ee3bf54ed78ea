"""Host and device in one compiled loop, mail to mail: what the frame path does, without the frames that nobody
reads.
"""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import assembled_entry_point, compiled
from firmware_protocol.schema import RECORD_SIZE, Direction
from gimbal_hil.loop.host import (
    C_AT,
    COUNTERS_AT,
    EVENT_CAPACITY,
    EVENT_COUNT,
    H_AT,
    MAIL_AT,
    OCTETS_AT,
    RECEIVERS_AT,
    RECORD_EVERY,
    REQUESTS,
    SEGMENT,
    SEGMENT_RUNS,
    SEGMENT_SIZE,
    TICK_SEGMENT,
    encode_host_mail,
    host_tick,
    write_row,
)
from sim_backend.device import DRIVE, device_tick, encode_device_mail

_TO_HOST, _TO_DEVICE = int(Direction.DEVICE_TO_HOST), int(Direction.HOST_TO_DEVICE)
#: a tick has at most this many frames, both directions together
MOST_FRAMES = 16
#: more events than one tick can bring
_EVENTS_PER_TICK = 16
#: 64-bit words of a frame row, as `gimbal_hil.data.runs.FRAME_ROW` packs it
FRAME_WORDS = 3


@compiled
def log_frames(
    octets: np.ndarray, start: int, size: int, frames: np.ndarray, place: int, tick: int, direction: int
) -> int:
    """Turn `size` bytes of records from `start` on into frame rows from `place` on; answers the next free place."""
    for at in range(start, start + size, RECORD_SIZE):
        payload = 0
        for k in range(8):
            payload |= (0 + octets[at + 2 + k]) << (8 * k)
        frames[place, 0], frames[place, 1] = tick, payload
        frames[place, 2] = (0 + octets[at]) | ((0 + octets[at + 1]) << 8) | (direction << 16)
        place += 1
    return place


@compiled
def events_fit(G: np.ndarray, before: int) -> bool:
    """Whether the events of one more tick fit into the ring, of which `before` are taken out."""
    return G[EVENT_COUNT] - before <= EVENT_CAPACITY - _EVENTS_PER_TICK


@compiled
def record_every(G: np.ndarray, plan: np.ndarray, every: int) -> int:
    """Ticks between log rows: what the segment in force asks, else `every`."""
    if G[TICK_SEGMENT] >= 0:
        wanted = int(plan[G[SEGMENT] * SEGMENT_SIZE + RECORD_EVERY])
        if wanted > 0:
            return wanted
    return every


@assembled_entry_point(device_tick)
def run_ticks(
    words: np.ndarray,
    plan: np.ndarray,
    P: np.ndarray,
    K: np.ndarray,
    X: np.ndarray,
    drive_words: np.ndarray,
    device_counters: np.ndarray,
    rows: np.ndarray,
    frames: np.ndarray,
    octets: np.ndarray,
    counts: np.ndarray,
    tick: int,
    ticks: int,
    step_ns: int,
    every: int,
    until_done: bool,
) -> int:
    """Run up to `ticks` ticks from number `tick` on; answers how many were run.

    `words` are a HostMemory's, P, K, X and `drive_words` a Device's. `rows` int64 (n, LOG_WORDS) gets a row every
    `every` ticks, `frames` int64 (m, FRAME_WORDS) all frames unless it has no room for one tick; `counts` int64 (2,)
    says how many of each.
    With `until_done` the run ends with the tick in which no segment runs or is due any more. Stops early when `rows`,
    `frames` or the event ring is full.
    """
    return _run_ticks(
        words,
        plan,
        P,
        K,
        X,
        drive_words,
        device_counters,
        rows,
        frames,
        octets,
        counts,
        tick,
        ticks,
        step_ns,
        every,
        until_done,
    )


@compiled
def _run_ticks(
    words: np.ndarray,
    plan: np.ndarray,
    P: np.ndarray,
    K: np.ndarray,
    X: np.ndarray,
    drive_words: np.ndarray,
    device_counters: np.ndarray,
    rows: np.ndarray,
    frames: np.ndarray,
    octets: np.ndarray,
    counts: np.ndarray,
    tick: int,
    ticks: int,
    step_ns: int,
    every: int,
    until_done: bool,
) -> int:
    # here and not in the entry point, because there every view would be counted
    G, mail, counters = words[:MAIL_AT], words[MAIL_AT:COUNTERS_AT], words[COUNTERS_AT:RECEIVERS_AT]
    H, C = words[H_AT:C_AT].view(np.float64), words[C_AT:OCTETS_AT].view(np.float64)
    drive = drive_words.view(DRIVE)[0]
    row_floats = rows.view(np.float64)
    logs_frames = frames.shape[0] >= MOST_FRAMES
    written, framed, events = 0, 0, G[EVENT_COUNT]
    for k in range(ticks):
        now = tick + k
        full = written == rows.shape[0] or (logs_frames and framed + MOST_FRAMES > frames.shape[0])
        if full or not events_fit(G, events):
            counts[0], counts[1] = written, framed
            return k
        if logs_frames:
            size = encode_device_mail(mail, device_counters, octets, 0)
            framed = log_frames(octets, 0, size, frames, framed, now, _TO_HOST)
        host_tick(mail, H, G, C, plan, now)
        if logs_frames:
            size = encode_host_mail(mail, counters, octets, 0)
            framed = log_frames(octets, 0, size, frames, framed, now, _TO_DEVICE)
        if now % record_every(G, plan, every) == 0:
            write_row(rows[written], row_floats[written], H, G, now, now * step_ns, 0)
            written += 1
        device_tick(mail, mail, P, K, X, drive)
        if until_done and G[SEGMENT_RUNS] == 0 and G[REQUESTS] == 0:
            counts[0], counts[1] = written, framed
            return k + 1
    counts[0], counts[1] = written, framed
    return ticks
