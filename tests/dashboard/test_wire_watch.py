"""Deadman margin, dropped frames and bus load, second by second."""

from __future__ import annotations

import pytest

from firmware_protocol.bus_load import bus_load, serial_load
from gimbal_hil.loop.host import Host
from gimbal_hil.loop.settings import host_configuration, shipped_settings
from gimbal_hil.realtime.telemetry import Exchange, Wire, WireWatch
from sim_backend.device import Device
from sim_backend.model import shipped_model

TICKS = 2100


def fed(wire: Wire, silent: range = range(0)) -> WireWatch:
    """Two seconds of host and antenna; in the ticks `silent` the antenna gets no set-point."""
    settings = shipped_settings()
    host, device, watch = Host(host_configuration(settings)), Device(shipped_model()), WireWatch(1_000_000, wire)
    received = b""
    for tick in range(TICKS):
        sent = host.tick(tick, tick * 1_000_000, received)
        watch.take(Exchange(host.row, received, sent), 3 if tick == TICKS - 50 else 0)
        received = device.tick(b"" if tick in silent else sent)
    return watch


def test_the_load_of_a_can_bus_is_what_its_messages_take_at_this_rate() -> None:
    assert fed(Wire(1_000_000)).state()["bus_load"] == pytest.approx(bus_load(1000.0, 1_000_000), rel=0.1)


def test_the_load_of_a_serial_line_is_that_of_its_busier_direction_and_a_socket_has_none() -> None:
    assert fed(Wire(921_600, True)).state()["bus_load"] == pytest.approx(serial_load(1000.0, 921_600), rel=0.1)
    assert fed(Wire()).state()["bus_load"] is None


def test_the_least_margin_lately_shows_set_points_that_stayed_away_and_dropped_frames_are_counted() -> None:
    calm, shaken = fed(Wire()).state(), fed(Wire(), range(TICKS - 60, TICKS - 53)).state()
    assert calm["deadman_margin_ticks"] - shaken["deadman_margin_ticks"] == 7
    assert shaken["rejected_lately"] == 3
    long_ago = fed(Wire(), range(300, 307)).state()
    assert long_ago["deadman_margin_ticks"] == calm["deadman_margin_ticks"]
