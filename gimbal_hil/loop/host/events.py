"""Events of the host core as people and logs see them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum

from firmware_protocol.enumerations import DriveState, FaultCode
from gimbal_hil.loop.host.states import EventCode, HostCause, HostState, LinkStatus, ModelNews, PointingState, Refusal


def word_of(state: IntEnum) -> str:
    """How a state, cause or event is called in files, requests and pages: its name in lower case."""
    return state.name.lower()


_MODEL_NEWS = {
    ModelNews.NONE: "nothing new of the model",
    ModelNews.STALE: "the torque sent contradicts the model's feed-forward, which fades out",
    ModelNews.RIGHT: "the model explains the torque again and comes back",
    ModelNews.SHAKES: "the loops shake with the observer; the cascade closes them from now on",
}
#: what the axes are called where nobody has named them
AXIS_NAMES = ("outer", "inner")


@dataclass(frozen=True, slots=True)
class HostEvent:
    """One change that the core saw or made at `tick`; `data` is plain JSON."""

    tick: int
    code: EventCode
    text: str
    data: dict[str, object] = field(default_factory=dict)


def host_event(axes: Sequence[str], tick: int, code: int, first: int, second: int, third: int) -> HostEvent:
    """One entry of the ring, in words; `axes` are the names of both."""
    kind = EventCode(code)
    if kind is EventCode.STATE:
        was, now, cause = _name(HostState, first), _name(HostState, second), _name(HostCause, third)
        because = "" if third == HostCause.NONE else f" ({cause})"
        # the state in which the drive stops by itself is the same for both
        asked = second == HostState.FAULT and third == HostCause.OPERATOR
        text = f"{was} to {'quick stop' if asked else now}{because}"
        return HostEvent(tick, kind, text, {"from": was, "to": now, "cause": cause})
    if kind is EventCode.SEGMENT_STARTED:
        return HostEvent(tick, kind, f"segment {second} started", {"place": first, "segment": second})
    if kind is EventCode.SEGMENT_ENDED:
        cause = _name(HostCause, third)
        return HostEvent(
            tick, kind, f"segment {second} ended ({cause})", {"place": first, "segment": second, "cause": cause}
        )
    if kind is EventCode.COMMAND_REFUSED:
        state, cause = _name(HostState, first), _name(HostCause, second)
        return HostEvent(tick, kind, f"command refused in state {state}", {"state": state, "cause": cause})
    if kind is EventCode.LINK:
        was, now = _name(LinkStatus, first), _name(LinkStatus, second)
        return HostEvent(tick, kind, f"feedback {was} to {now}", {"from": was, "to": now})
    if kind is EventCode.DRIVE:
        was, now, fault = _name(DriveState, first), _name(DriveState, second), _name(FaultCode, third)
        because = "" if third == FaultCode.NONE else f" ({fault})"
        return HostEvent(tick, kind, f"drive {was} to {now}{because}", {"from": was, "to": now, "fault": fault})
    if kind is EventCode.TRIPPED:
        cause = _name(HostCause, first)
        return HostEvent(
            tick, kind, f"{cause} on {axes[second]}", {"cause": cause, "axis": axes[second], "braking": bool(third)}
        )
    if kind is EventCode.IDENTITY:
        refusal = _name(Refusal, third)
        verdict = "" if third == Refusal.NONE else f": refused ({refusal})"
        text = f"antenna {first:08x}, serial number {second}{verdict}"
        return HostEvent(tick, kind, text, {"name_code": first, "serial_number": second, "refusal": refusal})
    if kind is EventCode.BEYOND_LIMIT:
        side = "upper" if second else "lower"
        return HostEvent(
            tick,
            kind,
            f"{axes[first]} moved past its {side} soft limit without torque",
            {"axis": axes[first], "side": side},
        )
    if kind is EventCode.MODEL:
        return HostEvent(
            tick,
            kind,
            f"{axes[first]}: {_MODEL_NEWS[ModelNews(second)]}",
            {"axis": axes[first], "news": _name(ModelNews, second)},
        )
    if kind is EventCode.FRICTION_LEVELS:
        text = f"{axes[first]}: friction at {second / 1000:g} of the model's, its viscous part at {third / 1000:g}"
        return HostEvent(
            tick, kind, text, {"axis": axes[first], "sliding_level": second / 1000, "viscous_level": third / 1000}
        )
    if kind is EventCode.POINTING:
        how, muted, error_deg = _name(PointingState, first), bool(second), round(math.degrees(third * 1e-6), 3)
        text = f"{how}, {'muted' if muted else 'not muted'}, {error_deg:g} deg off"
        return HostEvent(tick, kind, text, {"state": how, "muted": muted, "error_rad": third * 1e-6})
    return HostEvent(tick, kind, "base motion heard" if first else "base motion lost", {"heard": bool(first)})


def _name(kind: type[IntEnum], value: int) -> str:
    return word_of(kind(value))
