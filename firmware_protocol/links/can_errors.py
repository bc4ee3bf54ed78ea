"""What is wrong with a CAN bus itself: error frames (linux/can/error.h), and what the kernel says of an interface."""

from __future__ import annotations

import json
import shutil
import subprocess

from firmware_protocol.json_object import Json

#: bits of an error frame's identifier
_CLASSES = {
    0x001: "transmission timed out",
    0x004: "controller problem",
    0x008: "protocol violation",
    0x010: "transceiver",
    0x020: "no acknowledgement: nobody else on the bus, or at another bit rate",
    0x040: "bus-off",
    0x080: "bus error",
}
_PATIENCE_S = 2.0


def error_words(identifier: int) -> list[str]:
    """What an error frame of this identifier tells."""
    return [word for bit, word in _CLASSES.items() if identifier & bit] or ["error frame"]


def interface_problems(channel: str, bitrate: int) -> list[str]:
    """What speaks against a SocketCAN interface of this machine; nothing where the system cannot be asked."""
    command = shutil.which("ip")
    if command is None:
        return []
    try:
        asked = subprocess.run(
            [command, "-json", "-details", "link", "show", channel],
            capture_output=True,
            timeout=_PATIENCE_S,
            check=False,
            text=True,
        )
        told = json.loads(asked.stdout or "[]")
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return []
    return [problem for one in told if isinstance(one, dict) for problem in problems_of(one, channel, bitrate)]


def problems_of(told: Json, channel: str, bitrate: int) -> list[str]:
    """The same of one entry of `ip -json -details link show`."""
    data = (told.get("linkinfo") or {}).get("info_data") or {}
    found = []
    if told and "UP" not in told.get("flags", []):
        found.append(f"{channel} is down: sudo ip link set {channel} up type can bitrate {bitrate}")
    runs_at = (data.get("bittiming") or {}).get("bitrate")
    if runs_at not in (None, bitrate):
        found.append(f"{channel} runs at {runs_at} bit/s, link.bitrate is {bitrate}, which SocketCAN does not set")
    state, counts = data.get("state"), data.get("berr_counter") or {}
    if state not in (None, "ERROR-ACTIVE", "STOPPED"):
        counted = f" (errors sent {counts['tx']}, received {counts['rx']})" if {"tx", "rx"} <= set(counts) else ""
        cure = f": sudo ip link set {channel} type can restart, or restart-ms 100" if state == "BUS-OFF" else ""
        found.append(f"{channel} is {state.lower()}{counted}{cure}")
    return found
