"""Who answers on the link: taken in from its two frames, held against what this host speaks and was told to expect."""

from __future__ import annotations

import math

import numpy as np

from firmware_protocol import mail as m
from firmware_protocol.compiling import compiled
from firmware_protocol.schema import PROTOCOL_VERSION, TORQUE_STEP_NM
from gimbal_hil.loop.control import TORQUE_LIMIT
from gimbal_hil.loop.host.event_ring import report
from gimbal_hil.loop.host.layout import (
    AXES,
    AXIS_C,
    AXIS_C_SIZE,
    AXIS_G,
    AXIS_G_SIZE,
    AXIS_H,
    AXIS_H_SIZE,
    HAS_BRAKE,
    IDENTITY,
    IDENTITY_HEARD,
    MOST_TORQUE,
    PEER_NAME,
    PEER_PROTOCOL,
    PEER_SERIAL,
    PINNED_NAME,
    PINNED_SERIAL,
    REFUSAL,
    TORQUE_STEP,
)
from gimbal_hil.loop.host.states import EventCode, Refusal, number

_IDENTITY = number(EventCode.IDENTITY)
_NONE, _PROTOCOL, _NAME, _SERIAL = (
    number(Refusal.NONE),
    number(Refusal.PROTOCOL),
    number(Refusal.NAME),
    number(Refusal.SERIAL_NUMBER),
)
_TORQUE_RANGE, _CHANGED = number(Refusal.TORQUE_RANGE), number(Refusal.CHANGED)


def most_torque(limit_nm: float, step_nm: float) -> float:
    """The largest raw torque within a limit: a whole number of units, so that rounding cannot lead beyond it."""
    return min(math.floor(limit_nm / step_nm + 1e-9), float(m.SET_POINT_TORQUE_OUTER_HIGH))


_most_torque = compiled(most_torque)


@compiled
def forget_identity(G: np.ndarray) -> None:
    """The link was lost: whoever answers next says who it is before it gets torque."""
    G[IDENTITY] = 0


@compiled
def receive_identity(mail: np.ndarray, H: np.ndarray, G: np.ndarray, C: np.ndarray) -> None:
    """Take in who the antenna says it is; with both frames heard, `G[REFUSAL]` says whether it may be connected."""
    before, changed = G[IDENTITY], False
    if mail[m.IDENTITY] > 0:
        changed = (before & 1) != 0 and (
            mail[m.IDENTITY_NAME] != G[PEER_NAME] or mail[m.IDENTITY_PROTOCOL_VERSION] != G[PEER_PROTOCOL]
        )
        G[PEER_PROTOCOL], G[PEER_NAME] = mail[m.IDENTITY_PROTOCOL_VERSION], mail[m.IDENTITY_NAME]
        G[AXIS_G + HAS_BRAKE], G[AXIS_G + AXIS_G_SIZE + HAS_BRAKE] = (
            mail[m.IDENTITY_HAS_BRAKE_OUTER],
            mail[m.IDENTITY_HAS_BRAKE_INNER],
        )
        G[IDENTITY] |= 1
    if mail[m.IDENTITY_UNIT] > 0:
        serial = mail[m.IDENTITY_UNIT_SERIAL_NUMBER]
        changed = changed or ((before & 2) != 0 and (serial != G[PEER_SERIAL] or _units_differ(mail, H)))
        G[PEER_SERIAL] = serial
        G[IDENTITY] |= 2
        if not changed:
            _take_units(mail, H, C)
    if changed:
        G[REFUSAL] = _CHANGED
    elif G[IDENTITY] == IDENTITY_HEARD and before != IDENTITY_HEARD:
        G[REFUSAL] = _refusal(H, G, C)
        report(G, _IDENTITY, G[PEER_NAME], G[PEER_SERIAL], G[REFUSAL])


@compiled
def is_known(G: np.ndarray) -> bool:
    """Whether the antenna has said who it is since the link was last lost."""
    return bool(G[IDENTITY] == IDENTITY_HEARD)


@compiled
def is_refused(G: np.ndarray) -> bool:
    """Whether it is one that must not get torque."""
    return bool(G[IDENTITY] == IDENTITY_HEARD and G[REFUSAL] != _NONE)


@compiled
def _refusal(H: np.ndarray, G: np.ndarray, C: np.ndarray) -> int:
    if G[PEER_PROTOCOL] != PROTOCOL_VERSION:
        return _PROTOCOL
    if C[PINNED_NAME] >= 0.0 and G[PEER_NAME] != C[PINNED_NAME]:
        return _NAME
    if C[PINNED_SERIAL] >= 0.0 and G[PEER_SERIAL] != C[PINNED_SERIAL]:
        return _SERIAL
    for axis in range(AXES):
        most = H[AXIS_H + axis * AXIS_H_SIZE + TORQUE_STEP] * m.SET_POINT_TORQUE_OUTER_HIGH
        if C[AXIS_C + axis * AXIS_C_SIZE + TORQUE_LIMIT] > most:
            return _TORQUE_RANGE
    return _NONE


@compiled
def _unit(mail: np.ndarray, axis: int) -> float:
    """What a raw torque of 1 is, N m."""
    return TORQUE_STEP_NM * float(1 << mail[m.IDENTITY_UNIT_TORQUE_EXPONENT_OUTER + axis])


@compiled
def _units_differ(mail: np.ndarray, H: np.ndarray) -> bool:
    outer, inner = H[AXIS_H + TORQUE_STEP], H[AXIS_H + AXIS_H_SIZE + TORQUE_STEP]
    return bool(_unit(mail, 0) != outer or _unit(mail, 1) != inner)


@compiled
def _take_units(mail: np.ndarray, H: np.ndarray, C: np.ndarray) -> None:
    """The units of torque that set-points and measured torques have from now on."""
    for axis in range(AXES):
        h, step = AXIS_H + axis * AXIS_H_SIZE, _unit(mail, axis)
        H[h + TORQUE_STEP] = step
        H[h + MOST_TORQUE] = _most_torque(C[AXIS_C + axis * AXIS_C_SIZE + TORQUE_LIMIT], step)
