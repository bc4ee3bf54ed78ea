"""A log that begins in the middle of another run: the host stands as its image says."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import BEGINS, Event, EventKind, damage_of, open_run, replay
from gimbal_hil.loop.host import IMAGE_WORDS, Host, image_of, stand_as
from gimbal_hil.loop.settings import host_configuration, shipped_settings
from gimbal_hil.realtime.lockstep import give_again, host_of
from tests.runs.lockstep import record_lockstep

TICKS, FROM = 1200, 700


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("part") / "run"
    record_lockstep(folder, TICKS)
    return folder


def begin(tick: int, host: Host) -> Event:
    data = {"command": "image", "words": IMAGE_WORDS, "image": image_of(host), BEGINS: True}
    return Event(tick, 0, EventKind.COMMAND, "where the host stands", data)


def test_the_end_of_a_run_replays_from_the_image_of_its_host(recorded: Path) -> None:
    run = open_run(recorded)
    place = int(np.searchsorted(run.ticks["tick"], FROM))
    host = host_of(run)
    replay(replace(run, ticks=run.ticks[:place], replayable_ticks=place), host, lambda e: give_again(host, run, e))
    events = [event for event in run.events if event.kind is not EventKind.COMMAND or event.tick >= FROM]
    rest = replace(
        run,
        ticks=run.ticks[place:],
        frames=run.frames[run.frames["tick"] >= FROM],
        events=(begin(FROM, host), *events),
        replayable_ticks=len(run.ticks) - place,
    )
    again = host_of(rest)
    # what it followed at that tick is not in the image: a program begins there
    again.plan = host.plan
    found = replay(rest, again, lambda event: give_again(again, rest, event))
    assert found.ticks == len(rest.ticks) and (found.difference is None or found.difference.tick < 0)


def test_a_gap_is_damage_unless_the_log_says_where_the_host_stands_behind_it(recorded: Path) -> None:
    run = open_run(recorded)
    cut = replace(run, ticks=run.ticks[(run.ticks["tick"] < 300) | (run.ticks["tick"] >= FROM)])
    assert 300 in [damage.tick for damage in damage_of(cut)]
    told = replace(cut, events=(*cut.events, begin(FROM, host_of(run))))
    # the hashes of the whole file are those of all rows
    assert all(damage.tick < 0 for damage in damage_of(told))


@pytest.mark.parametrize(
    ("image", "words"), [("", 5), ("%%", IMAGE_WORDS), (None, IMAGE_WORDS + 1), ("//8AAAAAAAAAAA==", IMAGE_WORDS)]
)
def test_what_is_no_image_is_refused_in_one_line(image: object, words: object) -> None:
    host = Host(host_configuration(shipped_settings()))
    with pytest.raises(BadInputError, match="events"):
        stand_as(host, image, words, "events.jsonl: command at tick 3")
