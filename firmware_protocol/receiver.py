"""What a receiver remembers of each message: columns of the `receivers` array and the rules that judge a counter and a
silence.

The rules are plain integer functions, so that both codecs run the same ones. `receivers` is int64, shape
(number of messages + 1, COLUMNS); its last row counts frames that belong to no message.
"""

from __future__ import annotations

from enum import IntEnum

#: columns of one message's row
LAST_COUNTER, GOOD, CRC_ERRORS, OUT_OF_RANGE, DUPLICATES, LOST_FRAMES, TICKS_SINCE_GOOD, TROUBLE, STATUS = range(9)
COLUMNS = 9

#: columns of the last row
STRAY_IDENTIFIERS, STRAY_TRUNCATED, STRAY_DIRECTION = range(3)

#: `last counter` of a receiver that takes the next frame whatever its counter
UNKNOWN_COUNTER = -1

#: periods without a good frame after which a cyclic message is degraded, or lost
DEGRADED_PERIODS, LOST_PERIODS = 2, 10

#: ticks after which the counter of an event message is forgotten: its sender may have restarted meanwhile
EVENT_MEMORY_TICKS = 100

#: counter steps from here to 15 mean a late frame, not a loss: so many missing periods would have made the message lost
#: before
LATE_STEP = 12

#: what a bad or lost frame adds to TROUBLE and a good one takes away; DEGRADED from the level on, one frame in five or
#: worse
TROUBLE_STEP, TROUBLE_LEVEL, TROUBLE_TOP = 4, 8, 32

#: verdicts of `judge_counter` besides the number of frames lost
DUPLICATE = -1


class ReceiverStatus(IntEnum):
    """How far a message can be relied on."""

    LOST = 0
    DEGRADED = 1
    OK = 2


STATUS_LOST, STATUS_DEGRADED, STATUS_OK = int(ReceiverStatus.LOST), int(ReceiverStatus.DEGRADED), int(ReceiverStatus.OK)


def judge_counter(last: int, counter: int) -> int:
    """Frames lost before this one (0 and up), or DUPLICATE for a repeat or a frame that comes late."""
    if last == UNKNOWN_COUNTER:
        return 0
    step = (counter - last) & 15
    if step == 0 or step >= LATE_STEP:
        return DUPLICATE
    return step - 1


def more_trouble(trouble: int, frames: int) -> int:
    """TROUBLE after that many bad or lost frames."""
    grown = trouble + TROUBLE_STEP * frames
    return grown if grown < TROUBLE_TOP else TROUBLE_TOP


def judge_status(period_ticks: int, ticks_since_good: int, trouble: int, heard: int) -> int:
    """Status of a message; an event message (period 0) that was heard is never lost by silence."""
    if heard == 0:
        return STATUS_LOST
    if period_ticks > 0 and ticks_since_good > LOST_PERIODS * period_ticks:
        return STATUS_LOST
    if period_ticks > 0 and ticks_since_good > DEGRADED_PERIODS * period_ticks:
        return STATUS_DEGRADED
    return STATUS_DEGRADED if trouble >= TROUBLE_LEVEL else STATUS_OK


def memory_ticks(period_ticks: int) -> int:
    """Ticks of silence after which the next frame is taken whatever its counter."""
    return LOST_PERIODS * period_ticks if period_ticks > 0 else EVENT_MEMORY_TICKS
