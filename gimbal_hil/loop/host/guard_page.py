"""`docs/reference/guards.md`, made from the table of guards by `python -m gimbal_hil.loop.host.guard_page`."""

from __future__ import annotations

from textwrap import fill

from gimbal_hil.loop.host.guard_table import DRIVE_GUARDS, HOST_GUARDS

_HEAD = """# Guards

Made from `gimbal_hil/loop/host/guard_table.py` by `python -m gimbal_hil.loop.host.guard_page`; do not edit.

A stop never uses the sensor that is in doubt: the host chooses the stop by the cause and requests it from the drive
(`drive_control.stop`). If encoder and gyro differ by more than 1 rad/s, the drive's own stop uses neither and shorts
the windings, whatever was requested; a difference of 4 rad/s is a fault (`SENSORS_DISAGREE`). An axis that its weight
can move has a holding brake, which is closed whenever no axis is under torque; without power the windings are shorted.
No guard detects an encoder or gyro error of less than 0.015 rad/s, or of less than 5 % of the rate; where `init` sets
`one_sensor_window_s`, of less than 0.0017 rad/s.

"""


def _filled(*parts: str) -> str:
    return fill(" ".join(parts), width=120, break_on_hyphens=False, break_long_words=False)


def guard_page() -> str:
    """Text of `docs/reference/guards.md`."""
    lines = [
        "## Host",
        "",
        "| cause | trigger | reaction | look at first | left by | test |",
        "|---|---|---|---|---|---|",
    ]
    lines += [
        f"| `{g.cause.name}` | {g.trigger} | {g.reaction} | {g.look_at} | {g.reset} | `{g.test}` |" for g in HOST_GUARDS
    ]
    lines += [
        "",
        _filled(
            "An operator's `quick-stop` has the cause `OPERATOR`: ramp to rest by the encoder, held, brake closes;",
            "left by `reset`. In a fault that would end by itself (lost feedback, the drive's deadman) it takes that",
            "away: the drive goes on stopping as it does, and only `reset` leads back",
            "(`tests/host/test_supervisor.py`).",
            "Keys and their shipped values are in [the configuration](configuration.md).",
        ),
        "",
        "In addition, torque on the wire is limited; an axis without torque that passes a soft limit is reported as an",
        "event; a service process that dies or does no work for `service_timeout_s` ends the daemon (exit 3).",
    ]
    lines += ["", "## Drive", "", "| fault | trigger | reaction | test |", "|---|---|---|---|"]
    lines += [f"| `{g.fault.name}` | {g.trigger} | {g.reaction} | `{g.test}` |" for g in DRIVE_GUARDS]
    lines += [
        "",
        "`SENSOR_STUCK` and `HOLDING_BRAKE` are for other drives; the virtual antenna does not raise them.",
        "A fault latches; it is reset by an edge of `fault_reset` once its cause has gone.",
        "The tests are in `tests/device/guard_scenarios`.",
    ]
    return _HEAD + "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(guard_page(), end="")
