"""An axis that a plan does not name is held as configured beside one that it moves: what is out of balance falls only
where the configuration says so.
"""

from __future__ import annotations

import numpy as np
import pytest

from firmware_protocol.enumerations import BrakeState
from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.experiments import plan_from_document
from gimbal_hil.loop.host import UNNAMED, AxisCommand, HostState, Mode, Segment, Shape, UnnamedAxis, layout, program_of
from gimbal_hil.loop.settings import settings_from_document, shipped_settings
from gimbal_hil.realtime.lockstep import CompiledPath
from gimbal_hil.realtime.service.operator_commands import SegmentsRequest
from sim_backend.model import shipped_model
from tests.adapters.rig import link_section, settings_and_model

#: the inner axis of this antenna falls when nothing holds it
MODEL = shipped_model("thesis")
MOVES = {"mode": "rate", "shape": "hold", "value_rad_s": 0.2}
MOVING = AxisCommand(Mode.RATE, Shape.HOLD, (0.2,))


def antenna(unnamed: str) -> CompiledPath:
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    document["supervisor"]["unnamed_axis"] = unnamed
    path = CompiledPath(settings_from_document(document, "test"), MODEL, 1)
    path.connect()
    return path


def plan(**segment: object) -> dict[str, object]:
    return {"schema": 1, "name": "one axis", "segments": [{"outer": MOVES, "duration_s": 0.5, **segment}]}


@pytest.mark.parametrize(("unnamed", "falls"), [("free", True), ("position", False), ("brake", False)])
def test_an_axis_out_of_balance_that_a_plan_does_not_name_falls_only_where_it_is_left_free(
    unnamed: str, falls: bool
) -> None:
    path = antenna(unnamed)
    before = path.device.joint_positions
    path.host.command(plan_from_document(plan(), "plan").program(1000.0))
    path.advance(450)
    assert path.host.state is HostState.ACTIVE
    moved = np.subtract(path.device.joint_positions, before)
    assert moved[0] > 0.05
    assert bool(abs(moved[1]) > 0.05) is falls, moved
    assert abs(moved[1]) < 0.01 or falls
    closed = bool(path.device.drive.joints[1].brake_state == BrakeState.ENGAGED)
    assert closed is (unnamed == "brake")


def test_an_axis_that_a_plan_says_is_off_is_free_whatever_holds_others() -> None:
    path = antenna("position")
    before = path.device.joint_positions[1]
    path.host.command(plan_from_document(plan(inner={"mode": "off"}), "plan").program(1000.0))
    path.advance(450)
    assert abs(path.device.joint_positions[1] - before) > 0.05


def test_the_brake_opens_again_for_a_segment_that_names_the_axis() -> None:
    path = antenna("brake")
    both = Segment(MOVING, AxisCommand(Mode.RATE, Shape.HOLD, (0.3,)), 200)
    path.host.command(program_of([Segment(MOVING, UNNAMED, 200), both]))
    path.advance(150)
    stood, brake = path.device.joint_positions[1], path.device.drive.joints[1]
    assert brake.brake_state == BrakeState.ENGAGED
    path.advance(200)
    assert brake.brake_state == BrakeState.RELEASED
    assert path.device.joint_positions[1] - stood > 0.02


def test_an_operators_segment_is_held_alike_and_its_off_is_free() -> None:
    moving = {"mode": "rate", "parameters": [0.2]}
    for segment, expected in (
        ({"outer": moving}, UNNAMED),
        ({"outer": moving, "inner": {"mode": "off", "parameters": [1.0]}}, AxisCommand()),
    ):
        request = SegmentsRequest.model_validate({"command": "segments", "segments": [segment]})
        said = program_of([Segment(MOVING, expected)])
        assert request.program(1e-3).values.tobytes() == said.values.tobytes()


def test_a_segment_without_any_axis_leaves_both_off_as_without_a_plan() -> None:
    for unnamed in UnnamedAxis:
        values = program_of([Segment(UNNAMED, UNNAMED, 10), Segment(UNNAMED, MOVING, 10)]).holding(unnamed)
        modes = [
            values[k * layout.SEGMENT_SIZE + layout.AXIS_SEGMENT + axis * layout.AXIS_SEGMENT_SIZE]
            for k in range(2)
            for axis in range(2)
        ]
        held = Mode.POSITION if unnamed is UnnamedAxis.POSITION else Mode.OFF
        assert modes == [Mode.OFF, Mode.OFF, held, Mode.RATE]


def test_a_program_that_names_its_axes_is_followed_as_it_is() -> None:
    program = program_of([Segment(MOVING, AxisCommand(), 10)])
    assert program.holding(UnnamedAxis.POSITION) is program.values


def test_a_short_circuit_of_one_axis_is_refused_with_its_reason() -> None:
    document = shipped_settings().model_dump(mode="json", by_alias=True)
    document["supervisor"]["unnamed_axis"] = "short_circuit"
    with pytest.raises(BadInputError, match=r"supervisor\.unnamed_axis.*holds nothing.*position, brake or free"):
        settings_from_document(document, "test")


def test_drives_without_a_brake_of_ours_cannot_be_told_to_close_it() -> None:
    section = link_section("odrive")
    with pytest.raises(BadInputError, match=r"supervisor\.unnamed_axis.*odrive.*expected position or free"):
        settings_and_model(section, supervisor={"unnamed_axis": "brake"})
