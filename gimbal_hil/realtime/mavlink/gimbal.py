"""The gimbal protocol v2: a gimbal device and its gimbal manager in one component.

Source: MAVLink common message set and its "Gimbal Protocol v2" service. Both roles are one component, as the protocol
allows: the antenna has its own manager. What differs from a camera's gimbal:

- One component at a time is in control. It takes control by MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE, or by its first
  command while nobody has it. What others send is refused.
- A controller whose heartbeats stop is gone: the joints are braked to rest. So they are when rates are not repeated.
- Pitch and yaw are held in space together or not at all. A request that locks one of them is followed in the frame of
  the vehicle, and the flags of the attitude say so.
- A fault is left by the operator's `reset` alone; no message of MAVLink does it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from gimbal_hil.realtime.mavlink.angles import direction_rad, nearest_turn, quaternion
from gimbal_hil.realtime.mavlink.telling import DEVICE, InControl, Sender, Telling
from gimbal_hil.realtime.mavlink.values import Reach, Seen, Wish
from sim_backend.boresight import Boresight

NOBODY: Sender = (0, 0)
#: a heartbeat comes each second: after so long without one a controller is gone
HEARTBEAT_PATIENCE_S = 3.5
#: rates that are not repeated for so long end
RATE_PATIENCE_S = 1.0
#: share of the rate limit that a full deflection of a stick asks for, and that a way into stow or neutral takes
_STICK_SHARE, _WAY_SHARE = 0.5, 0.25
_SETTLING_S = 1.0
#: message -> seconds between two of them until another interval is asked for
_INTERVALS_S = {
    "HEARTBEAT": 1.0,
    "GIMBAL_DEVICE_ATTITUDE_STATUS": 0.1,
    "GIMBAL_MANAGER_STATUS": 0.2,
}
_SHORTEST_S = 0.02
_ON_REQUEST = ("GIMBAL_DEVICE_INFORMATION", "GIMBAL_MANAGER_INFORMATION", *_INTERVALS_S)


@dataclass(frozen=True, slots=True)
class Taken:
    """What comes of a message: answers to send, what to ask of the daemon, and the command whose result is the
    daemon's answer to that (with its sender).
    """

    answers: tuple[Any, ...] = ()
    wish: Wish | None = None
    command: tuple[int, Sender] | None = None


_NOTHING = Taken()


class Gimbal:
    """The protocol's state. `dialect` is pymavlink's common dialect; messages are its objects. Times are seconds of one
    clock that the caller keeps.
    """

    def __init__(self, dialect: ModuleType, reach: Reach, system: int, component: int, name: str = "antenna") -> None:
        self._m, self._reach = dialect, reach
        self._telling = Telling(dialect, reach, name)
        self.system, self.component = system, component
        self.controller: Sender = NOBODY
        self._second: Sender = NOBODY
        #: when each was heard; who was stopped for its silence is in control again only after a heartbeat
        self._heard_s: dict[Sender, float] = {}
        self._rates_until_s: float | None = None
        #: whose set-points were followed since they came into control
        self._moved: set[Sender] = set()
        #: RETRACT or NEUTRAL, while the last request was one
        self._place = 0
        self._intervals_s = dict(_INTERVALS_S)
        self._next_s = dict.fromkeys(_INTERVALS_S, 0.0)

    @property
    def boresight(self) -> Boresight:
        """Where the antenna looks in truth; on this side it looks along x."""
        return self._reach.boresight

    def take(self, message: Any, seen: Seen, now_s: float) -> Taken:
        """One message that came; messages to others, and those that the protocol does not have, come to nothing."""
        sender = (message.get_srcSystem(), message.get_srcComponent())
        kind = message.get_type()
        if kind == "HEARTBEAT":
            self._heard_s[sender] = now_s
            return _NOTHING
        if not self._is_for_us(message):
            return _NOTHING
        if kind == "COMMAND_LONG":
            return self._command(message, sender, seen, now_s)
        if not self._could(sender):
            # what others ask for leaves no trace: no time until which rates hold, no place
            return _NOTHING
        if kind in ("GIMBAL_DEVICE_SET_ATTITUDE", "GIMBAL_MANAGER_SET_ATTITUDE"):
            return self._followed(sender, now_s, self._attitude(message, seen, now_s))
        if kind == "GIMBAL_MANAGER_SET_PITCHYAW":
            asked = (message.pitch, message.yaw, message.pitch_rate, message.yaw_rate)
            return self._followed(sender, now_s, self._pitch_yaw(int(message.flags), asked, seen, now_s))
        if kind == "GIMBAL_MANAGER_SET_MANUAL_CONTROL":
            return self._followed(sender, now_s, self._manual(message, seen, now_s))
        return _NOTHING

    def result(self, command: tuple[int, Sender], accepted: bool) -> Any:
        """The acknowledgement of a command that the daemon has taken or refused."""
        number, sender = command
        return self._ack(number, sender, self._m.MAV_RESULT_ACCEPTED if accepted else self._m.MAV_RESULT_DENIED)

    def text(self, said: str, severe: bool = False) -> Any:
        """A line for people at the other end."""
        severity = self._m.MAV_SEVERITY_ERROR if severe else self._m.MAV_SEVERITY_WARNING
        return self._m.MAVLink_statustext_message(severity, said.encode("ascii", "replace")[:50])

    def overdue(self, now_s: float) -> tuple[Wish, str] | None:
        """A stop with its reason, when the controller is gone or rates were not repeated; told once."""
        if self.controller != NOBODY and now_s - self._heard_s.get(self.controller, -math.inf) > HEARTBEAT_PATIENCE_S:
            gone, self.controller = self.controller, NOBODY
            self._heard_s[gone], self._rates_until_s = -math.inf, None
            # who only looked on has no motion that could end: another client's goes on
            if gone not in self._moved:
                return None
            self._moved.discard(gone)
            return Wish("stop"), f"no heartbeat of {gone[0]}/{gone[1]}: stopped"
        if self._rates_until_s is not None and now_s > self._rates_until_s:
            self._rates_until_s = None
            return Wish("stop"), "rates not repeated: stopped"
        return None

    def due(self, seen: Seen, now_s: float) -> list[Any]:
        """Messages whose time has come."""
        names = [name for name, at_s in self._next_s.items() if now_s >= at_s and self._intervals_s[name] > 0.0]
        for name in names:
            interval_s = self._intervals_s[name]
            late_s = now_s - self._next_s[name]
            self._next_s[name] += interval_s if late_s < interval_s else late_s + interval_s
        return [self._telling.message(name, seen, self._in_control()) for name in names]

    def _in_control(self) -> InControl:
        return InControl(self.controller, self._second, self._place)

    def _is_for_us(self, message: object) -> bool:
        system, component = getattr(message, "target_system", 0), getattr(message, "target_component", 0)
        ours = system in (0, self.system) and component in (0, self.component)
        return ours and getattr(message, "gimbal_device_id", 0) in (0, DEVICE)

    # commands ---------------------------------------------------------------------------------------------------------

    def _command(self, message: Any, sender: Sender, seen: Seen, now_s: float) -> Taken:
        m, number = self._m, int(message.command)
        if number == m.MAV_CMD_REQUEST_MESSAGE:
            name = self._known(message.param1)
            if name is None:
                return Taken((self._ack(number, sender, m.MAV_RESULT_UNSUPPORTED),))
            return Taken(
                (
                    self._ack(number, sender, m.MAV_RESULT_ACCEPTED),
                    self._telling.message(name, seen, self._in_control()),
                )
            )
        if number == m.MAV_CMD_SET_MESSAGE_INTERVAL:
            name = self._known(message.param1)
            if name not in _INTERVALS_S or not math.isfinite(message.param2):
                return Taken((self._ack(number, sender, m.MAV_RESULT_UNSUPPORTED),))
            asked_s = message.param2 * 1e-6
            # 0: back to the usual one; below: off
            usual = _INTERVALS_S[name]
            self._intervals_s[name] = usual if asked_s == 0.0 else max(asked_s, _SHORTEST_S) if asked_s > 0.0 else 0.0
            self._next_s[name] = now_s
            return Taken((self._ack(number, sender, m.MAV_RESULT_ACCEPTED),))
        if number == m.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE:
            if int(_or(message.param7, 0.0)) not in (0, DEVICE):
                return _NOTHING
            return self._configure(message, sender, now_s)
        if number == m.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW:
            if int(_or(message.param7, 0.0)) not in (0, DEVICE):
                return _NOTHING
            if not self._could(sender):
                return Taken((self._ack(number, sender, m.MAV_RESULT_DENIED),))
            angles = [math.radians(value) for value in (message.param1, message.param2, message.param3, message.param4)]
            wish = self._pitch_yaw(int(_or(message.param5, 0.0)), angles, seen, now_s)
            if wish is None:
                return Taken((self._ack(number, sender, m.MAV_RESULT_DENIED),))
            self._come_into_control(sender, now_s)
            return Taken(wish=wish, command=(number, sender))
        return Taken((self._ack(number, sender, m.MAV_RESULT_UNSUPPORTED),))

    def _configure(self, message: Any, sender: Sender, now_s: float) -> Taken:
        """Who is in control: -1 leaves it, -2 the sender, -3 the sender no longer, else who is named."""
        wanted = []
        asked = ((message.param1, message.param2), (message.param3, message.param4))
        for (system, component), now in zip(asked, (self.controller, self._second), strict=True):
            if system == -1 or math.isnan(system):
                wanted.append(now)
            elif system == -2:
                wanted.append(sender)
            elif system == -3:
                wanted.append(NOBODY if now == sender else now)
            elif 0 <= system <= 255 and 0 <= component <= 255:
                wanted.append((int(system), int(component)))
            else:
                return Taken((self._ack(int(message.command), sender, self._m.MAV_RESULT_DENIED),))
        if any(self._is_silent(one) for one in {*wanted} - {self.controller, self._second}):
            return Taken((self._ack(int(message.command), sender, self._m.MAV_RESULT_DENIED),))
        before, (self.controller, self._second) = self.controller, wanted
        # whoever takes control has just been heard
        if self.controller not in (NOBODY, before):
            self._heard_s[self.controller] = now_s
        taken = Taken((self._ack(int(message.command), sender, self._m.MAV_RESULT_ACCEPTED),))
        if before in self._moved and self.controller == NOBODY:
            # the motion was the controller's
            self._moved.discard(before)
            self._rates_until_s = None
            return Taken(taken.answers, Wish("stop"))
        return taken

    def _ack(self, number: int, sender: Sender, result: int) -> Any:
        return self._m.MAVLink_command_ack_message(number, result, 0, 0, sender[0], sender[1])

    def _known(self, number: float) -> str | None:
        names = {getattr(self._m, f"MAVLINK_MSG_ID_{name}"): name for name in _ON_REQUEST}
        return names.get(int(_or(number, -1.0)))

    # set-points -------------------------------------------------------------------------------------------------------

    def _could(self, sender: Sender) -> bool:
        """Whether what the sender asks for counts: of who is in control, or of the first one when nobody is."""
        if self.controller == NOBODY:
            return not self._is_silent(sender)
        return sender in (self.controller, self._second)

    def _come_into_control(self, sender: Sender, now_s: float) -> None:
        """A request that is followed: by it somebody comes into control when nobody is."""
        if self.controller == NOBODY:
            self.controller = sender
            self._heard_s[sender] = now_s
        self._moved.add(self.controller)

    def _is_silent(self, sender: Sender) -> bool:
        return self._heard_s.get(sender) == -math.inf

    def _followed(self, sender: Sender, now_s: float, wish: Wish | None) -> Taken:
        if wish is None:
            return _NOTHING
        self._come_into_control(sender, now_s)
        return Taken(wish=wish)

    def _attitude(self, message: Any, seen: Seen, now_s: float) -> Wish | None:
        flags = int(message.flags)
        rates = (message.angular_velocity_y, message.angular_velocity_z)
        if place := self._to_a_place(flags, seen):
            return place
        if all(math.isnan(value) for value in message.q):
            return self._rates(flags, rates, now_s)
        direction = direction_rad(message.q, seen.position_rad[0])
        return None if direction is None else self._towards(flags, direction, seen)

    def _pitch_yaw(self, flags: int, asked: Sequence[float], seen: Seen, now_s: float) -> Wish | None:
        pitch, yaw, pitch_rate, yaw_rate = asked
        if place := self._to_a_place(flags, seen):
            return place
        if math.isnan(pitch) and math.isnan(yaw):
            return self._rates(flags, (pitch_rate, yaw_rate), now_s)
        if not all(math.isnan(value) or math.isfinite(value) for value in (pitch, yaw)):
            return None
        outer, inner = self._stands(flags, seen)
        return self._towards(flags, (outer if math.isnan(yaw) else -yaw, inner if math.isnan(pitch) else -pitch), seen)

    def _manual(self, message: Any, seen: Seen, now_s: float) -> Wish | None:
        flags = int(message.flags)
        if place := self._to_a_place(flags, seen):
            return place
        outer_most, inner_most = (_STICK_SHARE * rate for rate in self._reach.rate_rad_s)
        pitch, yaw = (_or(value, 0.0) for value in (message.pitch, message.yaw))
        if not (abs(pitch) <= 1.0 and abs(yaw) <= 1.0):
            return None
        return self._rates(flags, (pitch * inner_most, yaw * outer_most), now_s)

    def _rates(self, flags: int, rates: Sequence[float], now_s: float) -> Wish | None:
        """Rates about pitch and yaw (rad/s), NaN for none."""
        pitch, yaw = (_or(value, 0.0) for value in rates)
        if not (math.isfinite(pitch) and math.isfinite(yaw)):
            return None
        self._place, self._rates_until_s = 0, now_s + RATE_PATIENCE_S
        outer_most, inner_most = self._reach.rate_rad_s
        outer, inner = (max(-most, min(most, -rate)) for rate, most in ((yaw, outer_most), (pitch, inner_most)))
        return Wish("inertial_rate" if self._in_space(flags) else "rate", outer, inner)

    def _towards(self, flags: int, direction: tuple[float, float], seen: Seen) -> Wish | None:
        """To a direction: in space where both axes are locked, else of the joints, on the turn that is nearest."""
        outer, inner = direction
        in_space, from_north = self._in_space(flags), self._from_north(flags)
        if from_north is None or (in_space is not from_north and seen.base_rad is None):
            return None
        if in_space is not from_north and seen.base_rad is not None:
            outer += seen.base_rad[2] if in_space else -seen.base_rad[2]
        self._place, self._rates_until_s = 0, None
        if in_space:
            return Wish("pointing", math.remainder(outer, 2.0 * math.pi), inner)
        low, high = self._reach.low_rad, self._reach.high_rad
        stands = [_or(value, 0.0) for value in seen.position_rad]
        return Wish("position", *(nearest_turn((outer, inner)[i], stands[i], low[i], high[i]) for i in (0, 1)))

    def _to_a_place(self, flags: int, seen: Seen) -> Wish | None:
        """Into the stow or to where the antenna looks ahead; these flags come before all others."""
        place = flags & self._m.GIMBAL_DEVICE_FLAGS_RETRACT or flags & self._m.GIMBAL_DEVICE_FLAGS_NEUTRAL
        if not place:
            return None
        self._place, self._rates_until_s = place, None
        outer, inner = self._reach.stow_rad if place == self._m.GIMBAL_DEVICE_FLAGS_RETRACT else (0.0, 0.0)
        ways = zip((outer, inner), seen.position_rad, self._reach.rate_rad_s, strict=True)
        longest_s = max(abs(to - _or(at, to)) / (_WAY_SHARE * rate) for to, at, rate in ways)
        return Wish("position", outer, inner, longest_s + _SETTLING_S)

    def _stands(self, flags: int, seen: Seen) -> tuple[float, float]:
        """Where the antenna looks, in the frame that the flags give their angles in."""
        outer, inner = (_or(seen.position_rad[0], 0.0), _or(seen.position_rad[1], 0.0))
        from_north = bool(self._from_north(flags))
        if self._in_space(flags):
            return direction_rad(quaternion((outer, inner), seen.base_rad, from_north), outer) or (outer, inner)
        return outer + (seen.base_rad[2] if from_north and seen.base_rad is not None else 0.0), inner

    def _in_space(self, flags: int) -> bool:
        both = self._m.GIMBAL_DEVICE_FLAGS_PITCH_LOCK | self._m.GIMBAL_DEVICE_FLAGS_YAW_LOCK
        return flags & both == both

    def _from_north(self, flags: int) -> bool | None:
        """Whether yaw is from north, and not from where the vehicle looks; None where the flags contradict."""
        vehicle, earth = (
            flags & getattr(self._m, f"GIMBAL_DEVICE_FLAGS_YAW_IN_{frame}_FRAME") for frame in ("VEHICLE", "EARTH")
        )
        if vehicle and earth:
            return None
        return bool(earth or (not vehicle and flags & self._m.GIMBAL_DEVICE_FLAGS_YAW_LOCK))


def _or(value: float, otherwise: float) -> float:
    """The value, or another where there is none (NaN)."""
    return otherwise if math.isnan(value) else value
