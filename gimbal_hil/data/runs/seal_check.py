"""Is a run what its seal says? Every block's hash again, and how the run ended; what is missing is named."""

from __future__ import annotations

from collections.abc import Iterator

from gimbal_hil.data.runs.chain import CHAIN_FILE, SealedBlock, linked
from gimbal_hil.data.runs.difference import Difference
from gimbal_hil.data.runs.reader import RecordedRun


def broken_seal(run: RecordedRun) -> Iterator[Difference]:
    """What the seal shows, first things first; nothing in a sound run and in one that was recorded before there was a
    chain.
    """
    end = run.record.end
    if run.chain_damaged:
        yield Difference(
            -1,
            f"{CHAIN_FILE} line {len(run.blocks) + 1}",
            "unreadable",
            "a block",
            "the seal of the run is damaged there",
        )
        return
    if not run.blocks:
        if end is not None and end.last_block and any(end.counts.values()):
            yield Difference(-1, CHAIN_FILE, "missing", "the blocks of the run", "the seal of the run is gone")
        return
    last = run.blocks[-1]
    if end is not None and not end.last_block:
        yield Difference(-1, "hashes.last_block", "missing", last.sha256[:12], "run.yaml has lost the run's seal")
    yield from _missing(run, last)
    yield from _broken_block(run)
    if end is not None and end.last_block:
        if last.sha256 != end.last_block:
            reason = "the last block is not the one that run.yaml was sealed with"
            yield Difference(-1, CHAIN_FILE, last.sha256[:12], end.last_block[:12], reason)
        if run.record.seal != run.record.expected_seal:
            found, expected = run.record.seal[:12] or "missing", run.record.expected_seal[:12]
            reason = "who, when, software, exit status or log in run.yaml are not those that were sealed"
            yield Difference(-1, "seal", found, expected, reason)


def _missing(run: RecordedRun, last: SealedBlock) -> Iterator[Difference]:
    """Rows that were recorded and are not there. A run that was never finished may have lost its last ones with the
    machine's power.
    """
    if run.first_segment > 1 or run.record.end is None:
        return
    for part, found, recorded in (
        ("ticks", len(run.ticks), last.ticks),
        ("frames", len(run.frames), last.frames),
        ("events", len(run.event_lines), last.events),
    ):
        if found != recorded:
            lost = recorded - found
            what = (
                f"{lost} {part} that were recorded are missing"
                if lost > 0
                else f"{-lost} {part} were added to a finished run"
            )
            yield Difference(-1, part, f"{found} rows", f"{recorded} rows", what)


def _broken_block(run: RecordedRun) -> Iterator[Difference]:
    """The first block whose rows, or whose predecessor, are not those that were sealed."""
    before = run.record.genesis
    last = run.blocks[-1]
    # of a run whose old segments were given up, what is there is its end
    shortened = run.first_segment > 1
    gone_ticks = max(0, last.ticks - len(run.ticks)) if shortened else 0
    gone_frames = max(0, last.frames - len(run.frames)) if shortened else 0
    gone_events = max(0, last.events - len(run.event_lines)) if shortened else 0
    ticks = frames = events = 0
    for number, block in enumerate(run.blocks, 1):
        given_up = shortened and block.ticks <= gone_ticks and block.frames <= gone_frames
        # events have been given up with their rows only since they have segments too
        given_up = given_up and (block.events <= gone_events or gone_ticks + gone_frames > 0)
        if not given_up:
            rows = run.ticks[max(0, ticks - gone_ticks) : max(0, block.ticks - gone_ticks)]
            received = run.frames[max(0, frames - gone_frames) : max(0, block.frames - gone_frames)]
            lines = b"".join(run.event_lines[max(0, events - gone_events) : max(0, block.events - gone_events)])
            if linked(before, rows.tobytes(), received.tobytes(), lines) != block.sha256:
                if run.record.end is None and (block.ticks > len(run.ticks) or block.frames > len(run.frames)):
                    return  # its rows are not all there: the reader has said so
                place = f"block {number}" + (f" from tick {rows['tick'][0]} on" if len(rows) else "")
                what = (
                    "the fixed part of run.yaml, or the block's rows,"
                    if number == 1
                    else "rows or events of this block"
                )
                yield Difference(-1, place, "another hash", block.sha256[:12], f"{what} are not those that were sealed")
                return
        before, ticks, frames, events = block.sha256, block.ticks, block.frames, block.events
