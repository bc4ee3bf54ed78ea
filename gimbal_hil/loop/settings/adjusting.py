"""Gains and limits that may be changed while a daemon runs, each within the bounds that its configuration gives.

What is in force is the configuration with some numbers replaced, validated like a file: one way from settings to the
host's array, for the daemon and for replay alike.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass

from firmware_protocol.documents import validated
from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.control import GRAVITY_M_S2
from gimbal_hil.loop.host import LEAST_BRAKING_SHARE
from gimbal_hil.loop.settings.axis import AdjustableKey, AxisSettings, number_at
from gimbal_hil.loop.settings.daemon import DaemonSettings

#: axis -> key (`rate_loop.kp_s_per_rad`) -> value in force
Adjustments = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True, slots=True)
class AdjustableNumber:
    """One number that may be changed: what is in force, what the configuration says, and its bounds (SI units as the
    key says).
    """

    axis: str
    key: str
    value: float
    configured: float
    low: float
    high: float

    def as_dict(self) -> dict[str, object]:
        """For JSON."""
        return asdict(self)


def adjustable_numbers(configured: DaemonSettings, adjustments: Adjustments) -> list[AdjustableNumber]:
    """Every number that may be changed, axis by axis in the order of the file."""
    found = []
    for axis, section in configured.axes.items():
        for key in section.adjustable:
            low, high = section.bounds(key)
            value = number_at(section, key.value)
            assert value is not None, "the section was validated"
            in_force = adjustments.get(axis, {}).get(key.value, value)
            found.append(AdjustableNumber(axis, key.value, in_force, value, low, high))
    return found


def require_adjustable(configured: DaemonSettings, changes: Adjustments) -> None:
    """BadInputError, which names the bounds, for a number that may not be changed or not to this value."""
    known = {(number.axis, number.key): number for number in adjustable_numbers(configured, {})}
    for axis, values in changes.items():
        for key, value in values.items():
            number = known.get((axis, key))
            if number is None:
                may = ", ".join(one.key for one in known.values() if one.axis == axis)
                raise BadInputError(
                    f"{axis}.{key}",
                    "may not be changed while the daemon runs",
                    may or f"bounds for it in the configuration (axes.{axis}.adjustable)",
                )
            if not (math.isfinite(value) and number.low <= value <= number.high):
                raise BadInputError(
                    f"{axis}.{key}", f"{value:g} is beyond axes.{axis}.adjustable", f"{number.low:g} to {number.high:g}"
                )


def require_braking(settings: DaemonSettings, changes: Adjustments) -> None:
    """BadInputError for a torque limit among `changes` that leaves nothing to brake with: `settings` are those that
    would be in force. The weight is that on a level base, where the carrying axis has none about itself.
    """
    for place, (axis, section) in enumerate(settings.axes.items()):
        value, expected = changes.get(axis, {}).get(AdjustableKey.TORQUE), section.expectation
        if value is None or expected is None:
            continue
        across, _, along = expected.moment_kg_m
        weight = GRAVITY_M_S2 * math.hypot(across, along) if place else 0.0
        least = expected.disturbance_nm + weight
        least += LEAST_BRAKING_SHARE * section.limits.braking_rad_s2 * expected.inertia_kg_m2
        if value < least:
            loads = f"disturbance {expected.disturbance_nm:g} N m, weight {weight:.2g} N m"
            raise BadInputError(
                f"{axis}.{AdjustableKey.TORQUE.value}",
                f"{value:g} N m leaves nothing to brake {axis} with before a limit ({loads}, see `expectation`)",
                f"at least {least:.2f}",
            )


def merged(adjustments: Adjustments, changes: Adjustments, configured: DaemonSettings) -> dict[str, dict[str, float]]:
    """What is in force after the changes; a number that is back at its configured value is left out."""
    found: dict[str, dict[str, float]] = {}
    for axis, section in configured.axes.items():
        values = {**adjustments.get(axis, {}), **changes.get(axis, {})}
        kept = {key: float(value) for key, value in values.items() if value != number_at(section, key)}
        if kept:
            found[axis] = kept
    return found


def adjusted(configured: DaemonSettings, adjustments: Adjustments, where: str = "adjust") -> DaemonSettings:
    """The settings with these numbers in place; BadInputError where they do not fit together (a lower limit above the
    upper one), or name what there is not.
    """
    axes = dict(configured.axes)
    for axis, values in adjustments.items():
        if axis not in axes:
            raise BadInputError(where, f"no axis {axis!r}", " or ".join(axes))
        document = axes[axis].model_dump()
        # bounds hold for what the file says; whether a change is within them was asked before
        document["adjustable"] = {}
        for key, value in values.items():
            section, _, name = key.partition(".")
            if not isinstance(document.get(section), dict) or name not in document[section]:
                raise BadInputError(where, f"no number {axis}.{key}", "as in rate_loop.kp_s_per_rad")
            document[section][name] = value
        torque = values.get(AdjustableKey.TORQUE.value)
        if torque is not None and axes[axis].expectation is None:
            # nobody knows what the axis is held against: it brakes by as much less
            document["limits"]["braking_rad_s2"] *= min(1.0, torque / axes[axis].limits.torque_nm)
        axes[axis] = validated(AxisSettings, document, f"{where}: {axis}")
    return configured.model_copy(update={"axes": axes})


def adjustments_from(document: object, where: str) -> Adjustments:
    """Adjustments as a log keeps them; BadInputError where they are none."""
    expected = "axis -> key -> number, as in outer: {rate_loop.kp_s_per_rad: 50}"
    if not isinstance(document, dict) or not all(isinstance(values, dict) for values in document.values()):
        raise BadInputError(where, "are no adjustments", expected)
    for axis, values in document.items():
        for key, value in values.items():
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
                raise BadInputError(where, f"{axis}.{key} is {value!r}", expected)
    return document
