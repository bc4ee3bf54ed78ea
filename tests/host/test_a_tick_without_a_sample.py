"""A sample that is lost while a joint turns is no jump of it: the observer is carried on by the torque it knows."""

from __future__ import annotations

import numpy as np
import pytest

from firmware_protocol.links import FaultsConfig
from gimbal_hil.loop.host import AxisCommand, HostState, Mode, Segment, Shape, program_of
from gimbal_hil.loop.settings import settings_from_document
from gimbal_hil.pointing.arena import controller_settings
from gimbal_hil.realtime.lockstep import FramePath
from sim_backend.model import shipped_model

#: what `tune` finds for `realistic`: bandwidth, gusts above, gains of position and rate
STIFF = {"outer": (1880.0, 13.56, 158.6, 63.33), "inner": (945.0, 30.94, 192.2, 4.911)}
KEYS = ("bandwidth_rad_s", "gusts_above_rad_s", "position_kp_per_s", "rate_kp_s_per_rad")


@pytest.mark.parametrize("ticks", [1, 3])
def test_lost_ticks_do_not_leave_the_observer(ticks: int) -> None:
    document = controller_settings("all").model_dump(mode="json", by_alias=True)
    for axis, numbers in STIFF.items():
        document["axes"][axis]["observer"] = dict(zip(KEYS, numbers, strict=True))
    settings = settings_from_document(document, "stiff")
    # where the joints are fastest: after half a period
    cut = {"start_tick": 2510, "ticks": ticks}
    path = FramePath(settings, shipped_model("realistic"), 1, FaultsConfig.model_validate({"cuts": [cut]}))
    path.connect()
    outer, inner = (AxisCommand(Mode.POSITION, Shape.SINE, (0.0, size, 0.2, 0.0)) for size in (0.2, 0.15))
    found = path.run(program_of([Segment(outer, inner, 2800)]))
    assert path.host.state is HostState.ACTIVE
    assert not [one.text for one in found.events if "shake" in one.text]
    # the reference has gone on meanwhile
    torque = found.signals()["outer.torque"]
    lost = slice(2490, 2560)
    assert np.abs(np.diff(torque[lost])).max() < 0.35 * settings.axes["outer"].limits.torque_nm
