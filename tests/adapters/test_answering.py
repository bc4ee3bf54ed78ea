"""A late answer is not taken for that of the next question; a lost one costs one more tick."""

from __future__ import annotations

from hypothesis import example, given
from hypothesis import strategies as st

from firmware_protocol.adapters import Power
from firmware_protocol.adapters.answering import Answering
from firmware_protocol.adapters.gateway import Gateway
from firmware_protocol.links import DriveSection
from tests.adapters.told import Told


def accepted(arrivals: list[int | None], looks: int) -> list[tuple[int, int]]:
    """(tick of the look, newest question answered by then) of each set that is taken, where the answer to question k is
    on the bus from look `arrivals[k]` on, and None was lost.
    """
    answering, seen, taken = Answering(), set[int](), []
    for look in range(looks):
        # the look of tick k comes before the question of tick k + 1
        come = {k for k, at in enumerate(arrivals[: look + 1]) if at is not None and at <= look} - seen
        punctual = answering.is_of_this_tick([len(come)] * 2)
        if come:
            seen |= come
            if punctual:
                taken.append((look, max(come)))
    return taken


@given(st.lists(st.integers(2, 30), min_size=1, max_size=12))
def test_an_answer_that_is_late_by_a_tick_is_never_told_as_that_of_the_next(apart: list[int]) -> None:
    late = {10 + sum(apart[: place + 1]) for place in range(len(apart))}
    taken = accepted([k + 1 if k in late else k for k in range(400)], 400)
    assert all(look == question for look, question in taken)
    # the tick itself has no set; the next one has, because both answers come together
    assert {look for look, _ in taken} == set(range(400)) - late


@given(st.sets(st.integers(10, 190)))
def test_lost_answers_cost_at_most_as_many_ticks_again(lost: set[int]) -> None:
    taken = accepted([None if k in lost else k for k in range(200)], 200)
    assert all(look == question for look, question in taken)
    assert len(taken) >= 200 - 2 * len(lost)


def test_a_drive_that_answers_every_second_question_is_taken_by_its_word() -> None:
    taken = accepted([k if k % 2 else None for k in range(200)], 200)
    assert len(taken) >= 90


def test_a_backlog_is_passed_over_until_it_has_come_whole() -> None:
    arrivals = [*range(20), 24, 24, 25, 25, 25, *range(25, 40)]
    taken = accepted(list(arrivals), 40)
    assert all(look == question for look, question in taken)
    assert [look for look, _ in taken if 20 <= look < 28] == [25, 26, 27]


def test_a_backlog_that_comes_in_parts_is_passed_over_to_its_end() -> None:
    arrivals = [*range(20), 24, 24, 25, 25, 26, 26, *range(26, 40)]
    taken = accepted(list(arrivals), 40)
    assert all(look == question for look, question in taken)
    assert [look for look, _ in taken if 20 <= look < 28] == [26, 27]


@example([0] * 6 + [2] * 6)
@given(st.lists(st.integers(0, 3), max_size=60))
def test_what_never_comes_whole_is_taken_by_its_word_after_two_refusals(counts: list[int]) -> None:
    answering, refused = Answering(), 0
    for came in counts:
        taken = answering.is_of_this_tick([came, came])
        refused = 0 if taken else refused + (came > 0)
        assert refused <= 2 and not (taken and came == 0)


def test_a_set_that_may_answer_an_earlier_question_is_not_told() -> None:
    drives = [Told(), Told()]
    sections = [DriveSection(id=number, torque_nm=1.0) for number in (1, 2)]
    gateway = Gateway(drives, sections, "mine")

    def tells(answers: int) -> bool:
        gateway.pass_over()
        for drive in drives:
            for _ in range(answers):
                drive.says(Power.OFF)
        return bool(gateway.feedback())

    assert [tells(answers) for answers in (1, 0, 1, 2, 1)] == [True, False, False, True, True]
