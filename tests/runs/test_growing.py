"""A log that is read as it grows says what the whole log says, whenever one looks and however much comes at once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import GrowingLog, arrow_stream, open_run
from tests.runs.synthetic import record_run

TICKS = 300


def bytes_of(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in ("ticks.arrow", "frames.arrow")}


@pytest.mark.parametrize("piece_bytes", [64, 1 << 24])
def test_a_log_that_grows_by_any_number_of_bytes_is_read_once_and_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, piece_bytes: int
) -> None:
    monkeypatch.setattr(arrow_stream, "_PIECE_BYTES", piece_bytes)
    record_run(tmp_path / "run", TICKS, flush_every=20)
    whole, data = open_run(tmp_path / "run"), bytes_of(tmp_path / "run")
    sizes = dict.fromkeys(data, 0)
    for name in data:
        (tmp_path / "run" / name).write_bytes(b"")
    log, random = GrowingLog(tmp_path / "run"), np.random.default_rng(3)
    seen = [0]
    while sizes != {name: len(content) for name, content in data.items()}:
        # the writer puts the frames of a tick before its row
        for name in ("frames.arrow", "ticks.arrow"):
            sizes[name] = min(len(data[name]), sizes[name] + int(random.integers(1, 3000)))
            (tmp_path / "run" / name).write_bytes(data[name][: sizes[name]])
        seen.append(len(log.look(0).ticks))
    assert seen == sorted(seen) and len(set(seen)) > 5
    found = log.look(0)
    assert found.ticks.tobytes() == whole.ticks.tobytes() and found.frames.tobytes() == whole.frames.tobytes()


def test_rows_before_the_tick_asked_for_are_let_go(tmp_path: Path) -> None:
    record_run(tmp_path / "run", TICKS, flush_every=20)
    whole, log = open_run(tmp_path / "run"), GrowingLog(tmp_path / "run")
    for first in (37, 250, TICKS):
        found = log.look(first)
        assert found.ticks.tobytes() == whole.ticks[whole.ticks["tick"] >= first].tobytes()
        assert found.frames.tobytes() == whole.frames[whole.frames["tick"] >= first].tobytes()
    assert not len(log.look(0).ticks)


def test_what_is_no_log_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInputError):
        GrowingLog(tmp_path)
    record_run(tmp_path / "run", 20)
    (tmp_path / "run" / "ticks.arrow").write_bytes(b"something else that is long enough to be told from a header")
    with pytest.raises(BadInputError, match=r"ticks\.arrow"):
        GrowingLog(tmp_path / "run").look(0)
