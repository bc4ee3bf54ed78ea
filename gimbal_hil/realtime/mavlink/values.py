"""What passes between MAVLink's side and the daemon's.

MAVLink's side sees every antenna as one that looks along x of its inner body. One that looks along -x is the same
antenna with the signs of its inner joint and of its base's roll and pitch turned, and its base turned by half a turn:
`ahead` and `behind` are the way there and back.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from firmware_protocol.json_object import Json
from sim_backend.boresight import Boresight

Pair = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Reach:
    """What the configuration lets the joints do, the outer first: limits (rad, infinite where there are none), rates
    (rad/s), and where the antenna is stowed (rad).
    """

    low_rad: Pair
    high_rad: Pair
    rate_rad_s: Pair
    stow_rad: Pair
    boresight: Boresight = Boresight.AHEAD

    def ahead(self) -> Reach:
        """The same of an antenna that looks along x."""
        if self.boresight is Boresight.AHEAD:
            return self
        low, high = (self.low_rad[0], -self.high_rad[1]), (self.high_rad[0], -self.low_rad[1])
        return Reach(low, high, self.rate_rad_s, (self.stow_rad[0], -self.stow_rad[1]), self.boresight)


@dataclass(frozen=True, slots=True)
class Wish:
    """One request of the operator's socket: a set-point in one of its modes, or a stop."""

    mode: str
    outer: float = 0.0
    inner: float = 0.0
    over_s: float = 0.0

    @property
    def is_stop(self) -> bool:
        """Whether the joints are to be braked to rest."""
        return self.mode == "stop"

    def behind(self, boresight: Boresight) -> Wish:
        """The same for the antenna as it is."""
        if boresight is Boresight.AHEAD:
            return self
        half = math.pi if self.mode == "pointing" else 0.0
        return replace(
            self, outer=math.remainder(self.outer + half, 2.0 * math.pi) if half else self.outer, inner=-self.inner
        )

    def as_request(self) -> tuple[str, Json]:
        """Command and fields."""
        if self.is_stop:
            return "stop", {}
        fields = {"mode": self.mode, "outer": self.outer, "inner": self.inner, "over_s": self.over_s}
        return "set_point", {**fields, "lease": True}


@dataclass(frozen=True, slots=True)
class Seen:
    """What the daemon last told: positions (rad) and rates (rad/s) of both joints, NaN where they are not known; the
    attitude of the base (roll, pitch, yaw, rad), where navigation gives it.
    """

    time_s: float
    position_rad: Pair
    rate_rad_s: Pair
    active: bool
    mode: str
    linked: bool
    guard: str
    drive_fault: str
    base_rad: tuple[float, float, float] | None = None

    @property
    def held_in_space(self) -> bool:
        """Whether the joints follow space and not the base."""
        return self.active and self.mode in ("pointing", "inertial_rate")

    def ahead(self, boresight: Boresight) -> Seen:
        """The same of an antenna that looks along x."""
        if boresight is Boresight.AHEAD:
            return self
        base = None if self.base_rad is None else (-self.base_rad[0], -self.base_rad[1], self.base_rad[2] - math.pi)
        (outer, inner), (outer_rate, inner_rate) = self.position_rad, self.rate_rad_s
        return replace(self, position_rad=(outer, -inner), rate_rad_s=(outer_rate, -inner_rate), base_rad=base)


NOT_TOLD = Seen(0.0, (math.nan, math.nan), (math.nan, math.nan), False, "off", False, "", "none")


def seen_in(status: Json) -> Seen:
    """The same from the daemon's `status`."""
    outer, inner = status["position_rad"]

    def pair(values: Json) -> Pair:
        known = [math.nan if values[axis] is None else float(values[axis]) for axis in (outer, inner)]
        return known[0], known[1]

    base = status["base_attitude_rad"]
    return Seen(
        status["time_ns"] * 1e-9,
        pair(status["position_rad"]),
        pair(status["rate_rad_s"]),
        status["host_state"] == "active",
        status["mode"][outer],
        status["link"] == "ok",
        status["guard"],
        status["drive_fault"] or "none",
        (base["roll"], base["pitch"], base["yaw"]) if base else None,
    )
