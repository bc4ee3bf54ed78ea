"""The bus can carry what the daemon sends, and a rate that it cannot is refused."""

from __future__ import annotations

import pytest

from firmware_protocol.bus_load import (
    bus_load,
    frame_bits,
    highest_rate_hz,
    require_bus_carries,
    require_serial_carries,
    serial_load,
)
from firmware_protocol.errors import BadInputError
from firmware_protocol.schema import MESSAGES


def stuffed_length(bits: str) -> int:
    """Bits on the bus: after five equal bits, stuffed ones included, an opposite one is put in."""
    sent: list[str] = []
    for bit in bits:
        sent.append(bit)
        if len(sent) >= 5 and len(set(sent[-5:])) == 1:
            sent.append("1" if bit == "0" else "0")
    return len(sent)


def test_the_worst_case_frame_length_is_reached_by_the_worst_bit_pattern_and_never_passed():
    stuffable = 34 + 64
    worst = "0" * 5 + "".join("1111" if place % 2 == 0 else "0000" for place in range(24))
    worst = worst[:stuffable]
    tail = 10 + 3  # delimiters, acknowledge, end of frame; interframe space
    assert stuffed_length(worst) + tail == frame_bits() == 135
    assert stuffed_length("0" * stuffable) + tail <= frame_bits()


def test_the_default_rate_stays_under_sixty_per_cent_of_one_megabit():
    assert 0.5 < bus_load(1000.0, 1_000_000) < 0.6


def test_the_load_is_the_sum_over_messages_and_grows_with_the_rate():
    cyclic = sum(1000.0 / message.period_ticks for message in MESSAGES if message.period_ticks)
    assert bus_load(1000.0, 1_000_000) == pytest.approx((cyclic + 2 * 10.0) * 135 / 1e6)
    assert bus_load(500.0, 500_000) == pytest.approx(bus_load(1000.0, 1_000_000))


def test_a_rate_that_the_bus_cannot_carry_is_refused_with_the_highest_it_can():
    assert require_bus_carries(1000.0, 1_000_000, "daemon.yaml: rate_hz") < 0.6
    with pytest.raises(BadInputError) as refused:
        require_bus_carries(2000.0, 1_000_000, "daemon.yaml: rate_hz")
    assert (
        "daemon.yaml: rate_hz" in str(refused.value)
        and "119%" in str(refused.value)
        and "1005 Hz" in str(refused.value)
    )
    require_bus_carries(highest_rate_hz(1_000_000) - 1e-6, 1_000_000, "")


def test_a_serial_line_is_judged_by_its_busier_direction():
    assert 0.3 < serial_load(1000.0, 921_600) < 0.45
    with pytest.raises(BadInputError, match="at most"):
        require_serial_carries(1000.0, 230_400, "daemon.yaml: rate_hz")
