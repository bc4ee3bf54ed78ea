"""Which gains and limits are in force, and what an operator may make of them."""

from __future__ import annotations

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.loop.settings import (
    Adjustments,
    DaemonSettings,
    adjustable_numbers,
    adjusted,
    host_configuration,
    merged,
    require_adjustable,
    require_braking,
)
from gimbal_hil.realtime.telemetry import LiveView, pack_configuration


class LiveAdjustments:
    """`settings` are those in force; they change when the control process has taken a request, not when it is asked."""

    def __init__(self, configured: DaemonSettings, view: LiveView) -> None:
        self._configured, self._view = configured, view
        self.settings = configured
        self._in_force: Adjustments = {}
        #: what is in force once everything that was sent has been taken
        self._asked: Adjustments = {}

    @property
    def numbers(self) -> list[Json]:
        """Every number that may be changed, with its value and bounds."""
        return [number.as_dict() for number in adjustable_numbers(self._configured, self._in_force)]

    def asked(self, changes: Adjustments | None) -> Adjustments:
        """What is in force after these changes (None: as configured); BadInputError where they may not be."""
        if changes is None:
            return {}
        if not changes:
            raise BadInputError("adjust", "names no number", "as in outer: {rate_loop.kp_s_per_rad: 50}")
        require_adjustable(self._configured, changes)
        values = merged(self._asked, changes, self._configured)
        settings = adjusted(self._configured, values)
        require_braking(settings, changes)
        self._require_inside(settings)
        return values

    def packed(self, values: Adjustments) -> bytes:
        """What the control process is sent."""
        return pack_configuration(host_configuration(adjusted(self._configured, values)))

    def sent(self, values: Adjustments) -> None:
        """They are on their way."""
        self._asked = values

    def taken(self, values: Adjustments) -> Json:
        """They are in force; answers what the log keeps."""
        before, self._in_force = self._in_force, values
        self.settings = adjusted(self._configured, values)
        return {"command": "adjust", "values": values, "before": before}

    def refused(self) -> None:
        """What was on its way did not arrive."""
        self._asked = self._in_force

    def _require_inside(self, settings: DaemonSettings) -> None:
        """A travel limit that an axis is beyond already would stop it at once."""
        for axis, position in self._view.status()["position_rad"].items():
            limits = settings.axes[axis].limits
            low, high = limits.position_low_rad, limits.position_high_rad
            before = self.settings.axes[axis].limits
            moved = (low, high) != (before.position_low_rad, before.position_high_rad)
            outside = position is not None and not (
                (low is None or position >= low) and (high is None or position <= high)
            )
            if moved and outside:
                raise BadInputError(f"{axis}.limits", f"{axis} stands at {position:.4g} rad", "limits around it")
