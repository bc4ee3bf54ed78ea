"""The C device with one guard taken out: each of the Python device's mutants (`tests/device/mutants.py`) carried over,
and the scenarios of which at least one must notice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from typing import Any

from sim_backend.firmware import FirmwareAntenna, firmware_sources
from tests.device import mutants as python_mutants
from tests.device.bench import bench
from tests.device.guard_scenarios import SCENARIOS


@dataclass(frozen=True)
class CMutant:
    """A piece of a file and what stands there instead; `of` are source and replacement of the Python mutant."""

    file: str
    source: str
    instead: str
    of: tuple[str, str]

    @property
    def scenarios(self) -> tuple[str, ...]:
        """Those of the Python mutant."""
        return next(one.scenarios for one in python_mutants.MUTANTS if (one.source, one.instead) == self.of)

    def sources(self) -> dict[str, str]:
        """The changed file; AssertionError where the piece is not in it exactly once."""
        text = firmware_sources()[self.file]
        assert text.count(self.source) == 1, f"{self.file} holds {self.source!r} {text.count(self.source)} times"
        return {self.file: text.replace(self.source, self.instead)}


_G, _S, _D, _M = "gimbal_guards.c", "gimbal_stopping.c", "gimbal_drive.c", "gimbal_device.c"
_P = "gimbal_parts.h"
_STOPPING = "drive->state == GIMBAL_DRIVE_STATE_QUICK_STOP_ACTIVE"
_QUICK = f"{_STOPPING}\n            && drive->active_reaction <= GIMBAL_STOP_REACTION_BRAKE"
_PY_QUICK = "state == _QUICK_STOP and drive.active_reaction <= m.STOP_REACTION_BRAKE"
_HELD = "gimbal_within(torque, -limit, limit)"
_PY_HELD = "min(max(torque, -limit), limit)"
_FAST = "by_joint > settings->joints[axis].overspeed || by_gyro > settings->joints[axis].overspeed"
_PY_FAST = "max(abs(joint.joint_rate), abs(joint.gyro))"

#: (file, source, instead, source of the Python mutant, its replacement)
_ROWS = (
    (_G, "if (drive->margin == 0)", "if (false)", "if drive.margin == 0:", "if False:"),
    (
        _P,
        " || state == GIMBAL_DRIVE_STATE_QUICK_STOP_ACTIVE;",
        ";",
        "or state == m.DRIVE_STATE_QUICK_STOP_ACTIVE)",
        ")",
    ),
    (_D, _QUICK, "false", _PY_QUICK, "False"),
    (_D, _QUICK, _STOPPING, _PY_QUICK, "state == _QUICK_STOP"),
    (_D, "drive->margin = margin > 1 ? margin - 1 : 0;", "", "drive.margin = max(margin - 1, 0)", "pass"),
    (_D, "margin > 1 ? margin - 1 : 0;", "margin - 1;", "max(margin - 1, 0)", "margin - 1"),
    (_D, "(ahead == 0 || (ahead >= 512 && margin > 0))", "(ahead >= 512 && margin > 0)", "ahead == 0 or", ""),
    (_D, " || (ahead >= 512 && margin > 0)", "", "or (ahead >= 512 and margin > 0)", ""),
    (_D, "(ahead >= 512 && margin > 0)", "(ahead >= 512)", "and margin > 0)", ")"),
    (_D, "&& !gimbal_has_power(drive->state)\n", "\n", "and not has_power(drive.state) and", "and"),
    (
        _D,
        "GIMBAL_DRIVE_STATE_SWITCHED_ON && deadman_fed ?",
        "GIMBAL_DRIVE_STATE_SWITCHED_ON ?",
        "and deadman_fed:",
        ":",
    ),
    (
        _G,
        "&& drive->control_age > settings->control_silence_ticks",
        "&& false",
        "drive.control_age > drive.control_silence_ticks:",
        "False:",
    ),
    (
        _G,
        "return found(GIMBAL_FAULT_CODE_TRAVEL_LIMIT, axis);",
        "continue;",
        "return m.FAULT_CODE_TRAVEL_LIMIT, axis",
        "pass",
    ),
    (_G, "return 1;\n", "return 0;\n", "return 1\n", "return 0\n"),
    (_G, "own->travel_low ? -1 : 0", "own->travel_low ? 0 : 0", "return -1 if", "return 0 if"),
    (
        _G,
        "if ((side > 0 && torque > 0) || (side < 0 && torque < 0))",
        "if (side > 1)",
        "if side * torque > 0:",
        "if False:",
    ),
    (_G, " && drive->travel_cleared == 0", "", "and drive.travel_cleared == 0", ""),
    (
        _D,
        "if (drive->travel_cleared == 1 && !beyond)\n        drive->travel_cleared = 0;",
        "",
        "drive.travel_cleared = 0\n",
        "pass\n",
    ),
    (_D, "device->control.clear_travel && beyond", "beyond", "mail[m.DRIVE_CONTROL_CLEAR_TRAVEL] == 1 and", ""),
    (_G, _FAST, "by_gyro > settings->joints[axis].overspeed || by_joint < 0", _PY_FAST, "abs(joint.gyro)"),
    (_G, _FAST, "by_joint > settings->joints[axis].overspeed || by_gyro < 0", _PY_FAST, "abs(joint.joint_rate)"),
    (
        _G,
        "too_fast && drives_on ? 0",
        "too_fast && drives_on && side > 1 ? 0",
        "return 0 if too_fast and",
        "return 0 if False and",
    ),
    (
        _G,
        "too_fast && drives_on ?",
        "too_fast && (drives_on || side < 2) ?",
        "and (torque > 0) == (joint.joint_rate > 0)",
        "",
    ),
    (_G, _HELD, "gimbal_within(torque, -limit, INT64_MAX)", _PY_HELD, "max(torque, -limit)"),
    (_G, _HELD, "gimbal_within(torque, INT64_MIN, limit)", _PY_HELD, "min(torque, limit)"),
    (
        _M,
        "gimbal_without_outward(&settings->joints[axis], joint, joint->set_torque)",
        "joint->set_torque",
        "without_outward(drive, axis, joint.set_torque)",
        "joint.set_torque",
    ),
    (
        _M,
        "gimbal_within_torque_limit(settings, drive, axis, torque)",
        "(int32_t)torque",
        "within_torque_limit(drive, axis, torque)",
        "torque",
    ),
    (_M, "if (joint->set_enable == 1)", "if (true)", "if joint.set_enable == 1:", "if True:"),
    (
        _M,
        "if (drive->state == GIMBAL_DRIVE_STATE_OPERATION_ENABLED) {",
        "if (drive->state >= 2) {",
        "if drive.state == m.DRIVE_STATE_OPERATION_ENABLED:",
        "if drive.state >= 2:",
    ),
    (
        _G,
        "if (drive->joints[axis].winding > settings->joints[axis].max_winding)",
        "if (false)",
        "if joint.winding > joint.max_winding:",
        "if False:",
    ),
    (
        _G,
        "drive->supply < settings->min_supply && ",
        "false && ",
        "if drive.supply < drive.min_supply and",
        "if False and",
    ),
    (
        _G,
        "if (fault != GIMBAL_FAULT_CODE_NONE)\n            return found(fault, axis);",
        "(void)fault;",
        "if fault != m.FAULT_CODE_NONE:\n            return fault, axis",
        "pass",
    ),
    (_M, "return GIMBAL_FAULT_CODE_ENCODER;", "return GIMBAL_FAULT_CODE_NONE;", "return m.FAULT_CODE_ENCODER", "pass"),
    (_M, "return GIMBAL_FAULT_CODE_GYRO;", "return GIMBAL_FAULT_CODE_NONE;", "else m.FAULT_CODE_GYRO", "else 0"),
    (_M, "joint->sensor_fault = GIMBAL_FAULT_CODE_INTERNAL;", "", "joint.sensor_fault = m.FAULT_CODE_INTERNAL", "pass"),
    (_D, "if (reset_edge && now.fault", "if (now.fault", "if reset_edge and", "if True and"),
    (_D, "level == 1 && drive->reset_level == 0", "level == 1", "level == 1 and drive.reset_level == 0", "level == 1"),
    (
        _D,
        "if (reset_edge && now.fault == GIMBAL_FAULT_CODE_NONE)",
        "if (reset_edge)",
        "if reset_edge and fault == m.FAULT_CODE_NONE:",
        "if reset_edge:",
    ),
    (_D, "drive->reset_level = level;", "", "drive.reset_level = level\n", "pass\n"),
    (
        _D,
        "if (device->control.quick_stop && state != GIMBAL_DRIVE_STATE_QUICK_STOP_ACTIVE)",
        "if (false)",
        "mail_in[m.DRIVE_CONTROL_QUICK_STOP] == 1 and",
        "False and",
    ),
    (
        _D,
        "state != GIMBAL_DRIVE_STATE_QUICK_STOP_ACTIVE ? GIMBAL_DRIVE_STATE_READY",
        "true ? GIMBAL_DRIVE_STATE_READY",
        "SHUTDOWN and state != _QUICK_STOP:",
        "SHUTDOWN:",
    ),
    (
        _D,
        "state == GIMBAL_DRIVE_STATE_SWITCHED_ON && deadman_fed",
        "deadman_fed",
        "ENABLE_OPERATION and state == _SWITCHED_ON and",
        "ENABLE_OPERATION and",
    ),
    (_G, "return found(GIMBAL_FAULT_CODE_RUNAWAY, axis);", "continue;", "return m.FAULT_CODE_RUNAWAY, axis", "pass"),
    (_S, "if (joint->ran_away == 1)", "if (false)", "if runs_away(drive, axis):", "if False:"),
    (_G, "joint->ran_away = 0;", "(void)joint;", "joint.ran_away = 0", "pass"),
    (
        _G,
        "- gimbal_scaled(torque);",
        "+ gimbal_scaled(torque);",
        "- (torque << SCALE_BITS)",
        "+ (torque << SCALE_BITS)",
    ),
    (_G, "joint->effort / 2", "joint->effort * 4", "(joint.effort >> 1)", "(joint.effort << 2)"),
    (
        _M,
        "gimbal_watch_momentum(settings, drive, axis, gyro_before);",
        "(void)gyro_before;",
        "watch_momentum(drive, joint, before)",
        "pass",
    ),
    (
        _S,
        "joint->stop_integral = gimbal_within(",
        "(void)gimbal_within(",
        "joint.stop_integral = min(max(",
        "_ = min(max(",
    ),
    (_S, "gimbal_within(rate - step,", "gimbal_within(rate,", "min(rate - step,", "min(rate,"),
    (
        _S,
        "(now > 0 ? now : 0) + TICKS_AHEAD * step",
        "INT64_MAX",
        "min(rate - step, max(joint.joint_rate, 0) + _TICKS_AHEAD * step)",
        "rate - step",
    ),
    (
        _S,
        "(now < 0 ? now : 0) - TICKS_AHEAD * step",
        "INT64_MIN",
        "max(rate + step, min(joint.joint_rate, 0) - _TICKS_AHEAD * step)",
        "rate + step",
    ),
    (
        _S,
        "    take_motion(&drive->joints[axis]);\n    if (stop",
        "    if (stop",
        "    _take_motion(drive.joints[axis])\n    return",
        "    return",
    ),
    (_S, "if (stop == GIMBAL_STOP_REACTION_GYRO_STOP)", "if (stop < 9)", "if stop == _BY_GYRO else 0", ""),
    (
        _S,
        "gimbal_floor_scaled(-(own->stop_rate_gain * joint->gyro))",
        "gimbal_floor_scaled(own->stop_rate_gain * joint->gyro)",
        "return int(-(joint",
        "return int((joint",
    ),
    (_S, "if (!gimbal_supply_serves(settings, drive))", "if (false)", "if not supply_serves(K, drive):", "if False:"),
    (
        _G,
        "return found(GIMBAL_FAULT_CODE_SENSORS_DISAGREE, axis);",
        "continue;",
        "return m.FAULT_CODE_SENSORS_DISAGREE, axis",
        "pass",
    ),
    (
        _S,
        "\n            || gimbal_disagreement(joint) > settings->stop_disagreement",
        "",
        "or disagreement(drive, axis) > drive.stop_disagreement",
        "",
    ),
    (_S, "joint->sensor_fault == broken || ", "", "if fault == broken or", "if"),
    (
        _S,
        "joint->shorted = shorted ? 1 : 0;",
        "joint->shorted = shorted ? 0 : 0;",
        "joint.shorted = 1 if shorted",
        "joint.shorted = 1 if False",
    ),
    (
        _S,
        "drive->state != GIMBAL_DRIVE_STATE_OPERATION_ENABLED;",
        "false;",
        "else drive.state != m.DRIVE_STATE_OPERATION_ENABLED",
        "else False",
    ),
    (_M, "joint->brake_state == GIMBAL_BRAKE_STATE_ENGAGED,", "false,", "held |= _BRAKED", "pass"),
    (_S, "drive->joints[0].set_enable == 0 && ", "", "drive.joints[0].set_enable == 0 and", ""),
    (
        _S,
        "return joint->brake_command == GIMBAL_BRAKE_COMMAND_ENGAGE;",
        "return false;",
        "joint.brake_command == m.BRAKE_COMMAND_ENGAGE)",
        "False)",
    ),
    (
        _D,
        "drive->active_reaction = device->control.stop;",
        "",
        "drive.active_reaction = mail_in[m.DRIVE_CONTROL_STOP]",
        "pass",
    ),
    (
        _D,
        "(state != wanted || asks_for_another_stop(device))",
        "(state != wanted || (asks_for_another_stop(device) && false))",
        "or _asks_for_another_stop(mail_in, drive)",
        "",
    ),
    (_D, " && active > GIMBAL_STOP_REACTION_BRAKE", "", "and drive.active_reaction > m.STOP_REACTION_BRAKE", ""),
    (
        _S,
        " || drive->state_age >= settings->reaction_ticks + hold",
        "",
        "or drive.state_age >= drive.reaction_ticks + hold",
        "",
    ),
    (
        _S,
        "drive->rest_count >= settings->rest_ticks + hold || ",
        "",
        "drive.rest_count >= drive.rest_ticks + hold or",
        "",
    ),
    (_S, "settings->hold_ticks : 0", "1000000000 : 0", "drive.hold_ticks if", "10**9 if"),
)
MUTANTS = tuple(CMutant(file, source, instead, (of, by)) for file, source, instead, of, by in _ROWS)


MakeDevice = Callable[..., FirmwareAntenna]


def passes(scenario: str, device: MakeDevice) -> bool:
    """Whether a scenario holds on devices that are made so, of model, settings and seed."""
    with ExitStack() as made:

        def kept(*given: Any, **named: Any) -> FirmwareAntenna:
            antenna = device(*given, **named)
            made.callback(antenna.close)
            return antenna

        try:
            SCENARIOS[scenario](partial(bench, device=kept))
        except AssertionError:
            return False
        return True


def survivors(device_of: Callable[[CMutant], MakeDevice], mutants: Iterable[CMutant] = MUTANTS) -> list[str]:
    """Mutants that no scenario notices on the device that is built of them."""
    return [
        f"{one.file}: {one.source!r} -> {one.instead!r}"
        for one in mutants
        if all(passes(scenario, device_of(one)) for scenario in one.scenarios)
    ]
