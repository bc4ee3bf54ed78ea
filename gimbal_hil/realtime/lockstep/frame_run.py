"""Host and device in one compiled loop, block to block: every byte of every tick through encoder and decoder."""

from __future__ import annotations

import numpy as np

from firmware_protocol.compiling import assembled_entry_point, compiled
from firmware_protocol.schema import Direction
from gimbal_hil.loop.host import EVENT_COUNT, HOST_OCTETS, MAIL_AT, REQUESTS, SEGMENT_RUNS, SENT_AT, host_block_tick
from gimbal_hil.realtime.lockstep.compiled_run import MOST_FRAMES, events_fit, log_frames
from sim_backend.device import ANSWER_AT, DEVICE_OCTETS, device_block_tick, device_tick

_TO_HOST, _TO_DEVICE = int(Direction.DEVICE_TO_HOST), int(Direction.HOST_TO_DEVICE)


@assembled_entry_point(device_tick)
def run_blocks(
    words: np.ndarray,
    plan: np.ndarray,
    device_words: np.ndarray,
    x_size: int,
    frames: np.ndarray,
    counts: np.ndarray,
    tick: int,
    ticks: int,
    step_ns: int,
    until_done: bool,
) -> int:
    """Run up to `ticks` ticks from number `tick` on, on the words of a host and a device; answers how many were run.

    Rows go into the host's log. `frames` int64 (m, FRAME_WORDS) gets all frames unless it has no room for one tick.
    `counts` int64 (2,): how many bytes the host is to hear first, at the start of its octets, and in the end how many
    are left there for it; and how many frame rows were written. With `until_done` the run ends with the tick in which
    no segment runs or is due any more. Stops early when `frames` or the event ring is full.
    """
    return _run_blocks(words, plan, device_words, x_size, frames, counts, tick, ticks, step_ns, until_done)


@compiled
def _run_blocks(
    words: np.ndarray,
    plan: np.ndarray,
    device_words: np.ndarray,
    x_size: int,
    frames: np.ndarray,
    counts: np.ndarray,
    tick: int,
    ticks: int,
    step_ns: int,
    until_done: bool,
) -> int:
    # here and not in the entry point, because there every view would be counted
    G = words[:MAIL_AT]
    near = words[HOST_OCTETS[0] : HOST_OCTETS[1]].view(np.uint8)
    far = device_words[DEVICE_OCTETS[0] : DEVICE_OCTETS[1]].view(np.uint8)
    logs_frames = frames.shape[0] >= MOST_FRAMES
    heard, framed, events = counts[0], 0, G[EVENT_COUNT]
    done = 0
    while done < ticks and events_fit(G, events) and (not logs_frames or framed + MOST_FRAMES <= frames.shape[0]):
        now = tick + done
        if logs_frames:
            framed = log_frames(near, 0, heard, frames, framed, now, _TO_HOST)
        sent = host_block_tick(words, plan, heard, now, now * step_ns)
        if logs_frames:
            framed = log_frames(near, SENT_AT, sent, frames, framed, now, _TO_DEVICE)
        for at in range(sent):
            far[at] = near[SENT_AT + at]
        heard = device_block_tick(device_words, x_size, sent)
        for at in range(heard):
            near[at] = far[ANSWER_AT + at]
        done += 1
        if until_done and G[SEGMENT_RUNS] == 0 and G[REQUESTS] == 0:
            break
    counts[0], counts[1] = heard, framed
    return done
