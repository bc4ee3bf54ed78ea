"""Nonsense is refused with one line that names the log, the column and the expectation."""

from __future__ import annotations

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError
from gimbal_hil.discrepancy.preflight import check_logs
from gimbal_hil.signals import SignalsTable
from sim_backend.model import shipped_model

T = np.arange(6000) * 1e-3


def table(scale: float = 1.0, seconds: float = 6.0, torque: float = 1.0) -> SignalsTable:
    n = int(seconds * 1000)
    columns = {f"{axis}.torque": torque * np.sin(T[:n]) for axis in ("outer", "inner")}
    columns |= {f"{axis}.position": scale * 0.3 * np.sin(3.0 * T[:n]) for axis in ("outer", "inner")}
    return SignalsTable.of(("outer", "inner"), T[:n], columns, source="log.csv")


def test_sound_logs_pass() -> None:
    check_logs(shipped_model(), (table(), table()))


def test_degrees_in_the_place_of_radians_are_refused() -> None:
    with pytest.raises(BadInputError, match=r"outer\.position"):
        check_logs(shipped_model(), (table(scale=180.0 / np.pi),))


def test_torque_in_millinewton_metres_is_refused() -> None:
    with pytest.raises(BadInputError, match=r"outer\.torque"):
        check_logs(shipped_model(), (table(torque=2000.0),))


def test_a_log_without_motion_or_of_no_length_is_refused() -> None:
    with pytest.raises(BadInputError, match="never changes"):
        check_logs(shipped_model(), (table(scale=0.0),))
    with pytest.raises(BadInputError, match="lasts"):
        check_logs(shipped_model(), (table(seconds=2.0),))
