"""The drive's code with one guard taken out, interpreted: prints as JSON which mutants no scenario noticed. Run by
test_mutants.py.
"""

from __future__ import annotations

import importlib
import json
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from tests.device import bench as bench_module
from tests.device import guard_scenarios
from tests.interpreted import refuse_compiled

#: in the order of import, so that each one takes the mutated names of those before it
_NAMES = ("runaway", "guards", "stopping", "holding", "drive", "sensing", "core")
_MODULES = [importlib.import_module(f"sim_backend.device.{name}") for name in _NAMES]
_PACKAGE = importlib.import_module("sim_backend.device")


@dataclass(frozen=True)
class Mutant:
    """A piece of a module's source and what stands there instead; the scenarios of which at least one must fail."""

    module: str
    source: str
    instead: str
    scenarios: tuple[str, ...]


def _mutant(module: str, source: str, instead: str, *scenarios: str) -> Mutant:
    return Mutant(module, source, instead, scenarios)


MUTANTS = (
    _mutant("guards", "if drive.margin == 0:", "if False:", "silence_trips_the_deadman_at_the_end_of_its_window"),
    _mutant(
        "guards",
        "or state == m.DRIVE_STATE_QUICK_STOP_ACTIVE)",
        ")",
        "silence_trips_the_deadman_during_a_quick_stop_too",
    ),
    _mutant(
        "drive",
        "state == _QUICK_STOP and drive.active_reaction <= m.STOP_REACTION_BRAKE",
        "False",
        "silence_during_a_stop_without_sensors_does_not_bring_them_back",
    ),
    _mutant(
        "drive",
        "state == _QUICK_STOP and drive.active_reaction <= m.STOP_REACTION_BRAKE",
        "state == _QUICK_STOP",
        "silence_during_a_stop_without_sensors_does_not_bring_them_back",
    ),
    _mutant("drive", "drive.margin = max(margin - 1, 0)", "pass", "silence_trips_the_deadman_at_the_end_of_its_window"),
    _mutant("drive", "max(margin - 1, 0)", "margin - 1", "silence_trips_the_deadman_at_the_end_of_its_window"),
    _mutant("drive", "ahead == 0 or", "", "a_repeated_set_point_does_not_feed_the_deadman"),
    _mutant("drive", "or (ahead >= 512 and margin > 0)", "", "a_set_point_from_behind_does_not_feed_the_deadman"),
    _mutant("drive", "and margin > 0)", ")", "a_host_that_started_anew_is_heard_once_the_deadman_has_run_out"),
    _mutant(
        "drive", "and not has_power(drive.state) and", "and", "the_deadman_cannot_be_changed_while_it_guards_torque"
    ),
    _mutant("drive", "and deadman_fed:", ":", "torque_is_not_switched_on_before_set_points_come"),
    _mutant(
        "guards",
        "drive.control_age > drive.control_silence_ticks:",
        "False:",
        "silence_of_the_requests_is_a_communication_fault",
    ),
    _mutant("guards", "return m.FAULT_CODE_TRAVEL_LIMIT, axis", "pass", "travel_beyond_the_upper_limit_is_a_fault"),
    _mutant("guards", "return 1\n", "return 0\n", "travel_beyond_the_upper_limit_is_a_fault"),
    _mutant("guards", "return -1 if", "return 0 if", "travel_beyond_the_lower_limit_is_a_fault"),
    _mutant("guards", "if side * torque > 0:", "if False:", "torque_that_leads_out_of_travel_is_cut"),
    _mutant(
        "guards", "and drive.travel_cleared == 0", "", "cleared_travel_leads_back_in_and_is_a_fault_again_the_next_time"
    ),
    _mutant(
        "drive",
        "drive.travel_cleared = 0\n",
        "pass\n",
        "cleared_travel_leads_back_in_and_is_a_fault_again_the_next_time",
    ),
    _mutant(
        "drive",
        "mail[m.DRIVE_CONTROL_CLEAR_TRAVEL] == 1 and",
        "",
        "travel_that_nobody_cleared_is_a_fault_as_soon_as_torque_is_on",
    ),
    _mutant(
        "guards",
        "max(abs(joint.joint_rate), abs(joint.gyro))",
        "abs(joint.gyro)",
        "a_joint_that_is_too_fast_is_a_fault",
    ),
    _mutant(
        "guards",
        "max(abs(joint.joint_rate), abs(joint.gyro))",
        "abs(joint.joint_rate)",
        "a_gyro_that_sees_too_much_is_a_fault",
    ),
    _mutant("guards", "return 0 if too_fast and", "return 0 if False and", "torque_that_drives_a_fast_axis_on_is_cut"),
    _mutant("guards", "and (torque > 0) == (joint.joint_rate > 0)", "", "torque_that_drives_a_fast_axis_on_is_cut"),
    _mutant("guards", "min(max(torque, -limit), limit)", "max(torque, -limit)", "torque_is_held_within_its_limit"),
    _mutant("guards", "min(max(torque, -limit), limit)", "min(torque, limit)", "torque_is_held_within_its_limit"),
    _mutant(
        "core",
        "without_outward(drive, axis, joint.set_torque)",
        "joint.set_torque",
        "torque_that_leads_out_of_travel_is_cut",
    ),
    _mutant(
        "core",
        "within_torque_limit(drive, axis, torque)",
        "torque",
        "the_drives_own_stop_is_held_within_the_torque_limit",
    ),
    _mutant("core", "if joint.set_enable == 1:", "if True:", "an_axis_that_is_not_enabled_gets_no_torque"),
    _mutant(
        "core",
        "if drive.state == m.DRIVE_STATE_OPERATION_ENABLED:",
        "if drive.state >= 2:",
        "states_below_operation_enabled_know_no_torque",
    ),
    _mutant("guards", "if joint.winding > joint.max_winding:", "if False:", "a_hot_winding_is_a_fault_in_every_state"),
    _mutant(
        "guards",
        "if drive.supply < drive.min_supply and",
        "if False and",
        "a_low_supply_is_a_fault_once_the_power_stage_needs_it",
    ),
    _mutant(
        "guards",
        "if fault != m.FAULT_CODE_NONE:\n            return fault, axis",
        "pass",
        "an_encoder_at_the_end_of_its_range_is_a_fault_and_never_wraps",
    ),
    _mutant(
        "sensing",
        "return m.FAULT_CODE_ENCODER",
        "pass",
        "an_encoder_at_the_end_of_its_range_is_a_fault_and_never_wraps",
    ),
    _mutant("sensing", "else m.FAULT_CODE_GYRO", "else 0", "a_gyro_at_the_end_of_its_range_is_a_fault_and_never_wraps"),
    _mutant("sensing", "joint.sensor_fault = m.FAULT_CODE_INTERNAL", "pass", "a_motion_that_is_no_number_is_a_fault"),
    _mutant("drive", "if reset_edge and", "if True and", "a_fault_latches_when_its_cause_has_gone"),
    _mutant("drive", "level == 1 and drive.reset_level == 0", "level == 1", "a_fault_is_reset_by_an_edge_only"),
    _mutant(
        "drive",
        "if reset_edge and fault == m.FAULT_CODE_NONE:",
        "if reset_edge:",
        "a_fault_is_not_reset_while_its_cause_is_there",
    ),
    _mutant("drive", "drive.reset_level = level\n", "pass\n", "a_fault_is_reset_by_an_edge_only"),
    _mutant(
        "drive",
        "mail_in[m.DRIVE_CONTROL_QUICK_STOP] == 1 and",
        "False and",
        "a_quick_stop_outranks_the_request_beside_it",
    ),
    _mutant(
        "drive",
        "SHUTDOWN and state != _QUICK_STOP:",
        "SHUTDOWN:",
        "a_quick_stop_is_left_through_switch_on_disabled_only",
    ),
    _mutant(
        "drive",
        "ENABLE_OPERATION and state == _SWITCHED_ON and",
        "ENABLE_OPERATION and",
        "a_quick_stop_is_left_through_switch_on_disabled_only",
    ),
    _mutant("guards", "return m.FAULT_CODE_RUNAWAY, axis", "pass", "a_motor_that_turns_the_wrong_way_is_a_fault"),
    _mutant(
        "stopping",
        "if runs_away(drive, axis):",
        "if False:",
        "a_stop_by_torque_that_drives_the_axis_on_becomes_a_short",
    ),
    _mutant("runaway", "joint.ran_away = 0", "pass", "an_axis_that_ran_away_may_be_reset"),
    _mutant(
        "runaway",
        "- (torque << SCALE_BITS)",
        "+ (torque << SCALE_BITS)",
        "torque_that_moves_the_axis_as_it_should_is_no_runaway",
    ),
    _mutant("runaway", "(joint.effort >> 1)", "(joint.effort << 2)", "a_motor_that_turns_the_wrong_way_is_a_fault"),
    _mutant("sensing", "watch_momentum(drive, joint, before)", "pass", "a_motor_that_turns_the_wrong_way_is_a_fault"),
    _mutant("stopping", "joint.stop_integral = min(max(", "_ = min(max(", "a_quick_stop_at_rest_stays_where_it_was"),
    _mutant(
        "stopping",
        "min(rate - step,",
        "min(rate,",
        "a_quick_stop_decelerates_and_holds_against_gravity",
    ),
    _mutant("stopping", "if stop == _BY_GYRO else 0", "", "coasting_applies_no_torque"),
    _mutant(
        "stopping", "return int(-(joint", "return int((joint", "the_drives_own_stop_is_held_within_the_torque_limit"
    ),
    _mutant(
        "stopping", "if not supply_serves(K, drive):", "if False:", "holding_becomes_braking_when_a_winding_gets_hot"
    ),
    _mutant(
        "guards", "return m.FAULT_CODE_SENSORS_DISAGREE, axis", "pass", "sensors_that_contradict_each_other_are_a_fault"
    ),
    _mutant(
        "stopping",
        "or disagreement(drive, axis) > drive.stop_disagreement",
        "",
        "a_stop_uses_no_sensor_while_they_contradict_each_other",
    ),
    _mutant("stopping", "if fault == broken or", "if", "a_stop_does_not_use_the_sensor_that_failed"),
    _mutant(
        "holding",
        "joint.shorted = 1 if shorted",
        "joint.shorted = 1 if False",
        "a_shorted_winding_stops_an_axis_whose_sensors_lie",
    ),
    _mutant(
        "holding",
        "else drive.state != m.DRIVE_STATE_OPERATION_ENABLED",
        "else False",
        "a_drive_without_power_shorts_its_windings",
    ),
    _mutant("holding", "held |= _BRAKED", "pass", "an_axis_that_its_weight_moves_is_held_by_its_brake_without_power"),
    _mutant(
        "holding",
        "drive.joints[0].set_enable == 0 and",
        "",
        "a_brake_opens_for_torque_and_closes_when_no_axis_is_under_torque",
    ),
    _mutant("holding", "joint.brake_command == m.BRAKE_COMMAND_ENGAGE)", "False)", "a_brake_obeys_its_command"),
    _mutant(
        "drive",
        "drive.active_reaction = mail_in[m.DRIVE_CONTROL_STOP]",
        "pass",
        "a_quick_stop_takes_the_way_that_it_is_asked_for",
    ),
    _mutant(
        "drive", "or _asks_for_another_stop(mail_in, drive)", "", "a_quick_stop_that_runs_can_be_asked_to_trust_less"
    ),
    _mutant(
        "drive",
        "and drive.active_reaction > m.STOP_REACTION_BRAKE",
        "",
        "a_quick_stop_that_runs_can_be_asked_to_trust_less",
    ),
    _mutant(
        "stopping",
        "or drive.state_age >= drive.reaction_ticks + hold",
        "",
        "a_reaction_that_does_not_come_to_rest_ends_in_time",
    ),
    _mutant(
        "stopping",
        "drive.rest_count >= drive.rest_ticks + hold or",
        "",
        "decelerating_holds_for_its_time_and_then_lets_go",
    ),
    _mutant(
        "stopping",
        "min(rate - step, max(joint.joint_rate, 0) + _TICKS_AHEAD * step)",
        "rate - step",
        "a_false_step_of_the_encoder_as_a_stop_begins_moves_nothing",
    ),
    _mutant(
        "stopping",
        "max(rate + step, min(joint.joint_rate, 0) - _TICKS_AHEAD * step)",
        "rate + step",
        "a_false_step_of_the_encoder_as_a_stop_begins_moves_nothing",
    ),
    _mutant(
        "stopping",
        "    _take_motion(drive.joints[axis])\n    return",
        "    return",
        "a_ramp_goes_on_from_the_motion_after_the_short_that_stood_in_for_it",
    ),
    _mutant("stopping", "drive.hold_ticks if", "10**9 if", "decelerating_holds_for_its_time_and_then_lets_go"),
)


def _load(module: ModuleType, source: str) -> None:
    assert module.__file__ is not None
    exec(compile(source, module.__file__, "exec"), module.__dict__)


def _build(mutant: Mutant | None) -> None:
    """Load the device anew, with one piece of source changed."""
    for module in _MODULES:
        assert module.__file__ is not None
        source = Path(module.__file__).read_text()
        if mutant is not None and module.__name__.endswith(f".{mutant.module}"):
            assert mutant.source in source, f"{mutant.module} holds no {mutant.source!r}"
            source = source.replace(mutant.source, mutant.instead, 1)
        _load(module, source)
    bench_module.device_tick = _PACKAGE.core.device_tick  # type: ignore[attr-defined]


def _passes(scenario: str) -> bool:
    try:
        guard_scenarios.SCENARIOS[scenario](lambda **settings: bench_module.bench(interpreted=True, **settings))
    except AssertionError:
        return False
    return True


def main() -> None:
    """Scenarios that fail on the true device, mutants that live, and how long it took."""
    refuse_compiled("tests.device.mutants")
    began = time.perf_counter()
    needed = sorted({name for mutant in MUTANTS for name in mutant.scenarios})
    _build(None)
    broken = [name for name in needed if not _passes(name)]
    survivors = []
    for mutant in MUTANTS:
        _build(mutant)
        if all(_passes(name) for name in mutant.scenarios):
            survivors.append(f"{mutant.module}: {mutant.source!r} -> {mutant.instead!r}")
    answer = {"mutants": len(MUTANTS), "broken": broken, "survivors": survivors, "seconds": time.perf_counter() - began}
    json.dump(answer, sys.stdout)


if __name__ == "__main__":
    main()
