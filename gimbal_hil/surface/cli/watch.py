"""`gimbal-hil watch`: a running daemon in a terminal, over ssh too. It asks the service process, never the loop."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated

import typer

from firmware_protocol.json_object import Json
from gimbal_hil.surface.cli.option_types import DaemonRun

_WIDTH = 40
_COLOURS = {"good": "32", "warning": "33", "bad": "1;31"}
_ACTS = {"s": "stop", "b": "adjust_back", "n": "learn_anew"}
_UNWATCHED = {"loading": "is being loaded", "waiting": "waits for torque"}
_KEYS = "keys: s stop, b gains and limits back to the configuration, n learn anew what the model lacks, q leave"


def command(
    run: DaemonRun = None,
    every: Annotated[float, typer.Option(metavar="SECONDS", help="Time between two looks.", min=0.05)] = 0.25,
    once: Annotated[bool, typer.Option("--once", help="One look, then end (as for scripts).")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="The daemon's own answer, one JSON object a look.")] = False,
) -> int:
    """Show state, axes, torque, deadline misses and recording of a running daemon, until it ends or Ctrl-C.

    In a terminal one key acts: s stops, b takes gains and limits back to the configuration, n takes what the
    model lacks from now on as usual, q leaves.
    """
    import json
    import shutil
    import sys
    import textwrap

    from firmware_protocol.errors import EXIT_DONE, LinkError
    from gimbal_hil.realtime.operator import OperatorClient
    from gimbal_hil.surface.cli.following import after_daemon
    from gimbal_hil.surface.cli.next_line import print_next
    from gimbal_hil.surface.cli.operate import daemon_run

    folder = daemon_run(run)
    in_place = sys.stdout.isatty() and not once and not as_json
    with OperatorClient(folder) as client, _keys(in_place and sys.stdin.isatty()) as pressed:
        while True:
            try:
                answer = client.request("status")
            except LinkError:
                print("the daemon has ended")
                print_next(after_daemon(folder, EXIT_DONE))
                return EXIT_DONE
            if as_json:
                print(json.dumps(answer), flush=True)
            else:
                columns = shutil.get_terminal_size().columns if sys.stdout.isatty() else 80
                lines = _on_screen(answer, columns, sys.stdout.isatty() and "NO_COLOR" not in os.environ)
                if in_place:
                    lines += textwrap.wrap(_KEYS, columns)
                print(
                    "".join(f"\033[2K{line}\n" for line in lines) if in_place else "\n".join(lines), end="", flush=True
                )
                print(
                    f"\033[J\033[{len(lines)}A" if in_place and not once else "" if in_place else "\n",
                    end="",
                    flush=True,
                )
            if once:
                return EXIT_DONE
            key = pressed(every)
            if key == "q":
                return EXIT_DONE
            if key in _ACTS:
                client.request(_ACTS[key])


@contextlib.contextmanager
def _keys(reading: bool) -> Iterator[Callable[[float], str]]:
    """Waits for a key, which counts without Enter, so many seconds; the terminal is put back as it was."""
    import sys

    if not reading:

        def wait(seconds: float) -> str:
            time.sleep(seconds)
            return ""

        yield wait
        return
    import select
    import termios
    import tty

    before = termios.tcgetattr(sys.stdin)
    tty.setcbreak(sys.stdin)

    def pressed(seconds: float) -> str:
        ready, _, _ = select.select([sys.stdin], [], [], seconds)
        return os.read(sys.stdin.fileno(), 1).decode(errors="replace") if ready else ""

    try:
        yield pressed
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)


def status_lines(answer: Json) -> list[str]:
    """What a `status` answer says, a line each."""
    return [text for text, _ in _told(answer)]


def _on_screen(answer: Json, columns: int, coloured: bool) -> list[str]:
    """The same, no line wider than the terminal, in colour where it has it."""
    import textwrap

    from firmware_protocol.errors import shown

    found = []
    for told, tone in _told(answer):
        text = shown(told)
        # spaces that set columns stay: only what is too long is broken
        pieces = [text] if len(text) <= columns else textwrap.wrap(text, columns, subsequent_indent="  ")
        begin, end = (f"\033[{_COLOURS[tone]}m", "\033[0m") if coloured and tone else ("", "")
        found += [f"{begin}{piece}{end}" for piece in pieces]
    return found


def _told(answer: Json) -> list[tuple[str, str]]:
    """Lines with the tone of each: good, warning, bad, or none."""
    status = answer["status"]
    statistics = status["statistics"]
    drive = status["drive_told"] or "not heard"
    if status["link"] == "lost" and status["drive_state"]:
        drive += ", last heard"
    tone = {"fault": "bad", "stopping": "warning", "active": "good"}.get(status["host_state"], "")
    seconds = status["time_ns"] / 1e9
    host = f"host {status['host_told']}  drive {drive}  link {status['link']}"
    lines = [
        (
            f"{seconds:.1f} s  tick {status['tick']}  {host}",
            "bad" if status["link"] == "lost" else tone,
        ),
        *_trouble_lines(status, seconds),
    ]
    for axis, position in status["position_rad"].items():
        rate, torque = status["rate_rad_s"][axis], status["torque_nm"][axis]
        lines += [
            (
                f"{axis:<12} {status['mode'][axis]:<13} {_degrees(position, 10, 3)} {_number(position, 9, 4)} rad "
                f"{_degrees(rate, 9, 2)}/s {_number(torque, 9, 4)} N m",
                "",
            ),
            (f"{'':<12} {_bar(position, (status.get('limits') or {}).get(axis) or {})}", ""),
        ]
    pointing = status.get("pointing") or {}
    if pointing.get("state", "off") != "off":
        muted = pointing["muted"]
        lines.append(
            (f"pointing: {pointing['state']}, {'muted' if muted else 'not muted'}", "warning" if muted else "")
        )
    lines += _model_lines(status.get("observer") or {})
    if status.get("adjusted"):
        lines.append(("not as configured: " + ", ".join(status["adjusted"]), "warning"))
    return [*lines, *_machine_lines(status, statistics, answer.get("recording"))]


def _trouble_lines(status: Json, seconds: float) -> list[tuple[str, str]]:
    """A stop: what, since when, what to do; else the drive's fault, or where the program is."""
    trouble, fault = status.get("trouble"), status["drive_fault"]
    complaint = status.get("drive_complaint")
    if trouble:
        since = f"for {max(0.0, seconds - trouble['since_s']):.0f} s, since {trouble['since_s']:.1f} s"
        look = f"; look at {trouble['look_at']}" if trouble["look_at"] else ""
        by = trouble["left_by"]
        on = "gimbal-hil reset" if "reset" in by else by
        return [
            (f"STOPPED {since}: {trouble['what']}{': ' if trouble['why'] else ''}{trouble['why']}", "bad"),
            (f"now: {trouble['happens']}{look}; to go on: {on}", "bad"),
        ]
    if fault not in (None, "none"):
        return [(f"fault: {fault}{f' ({complaint})' if complaint else ''}", "bad")]
    at = f"in segment {status['segment']} of a program" if status["segment"] >= 0 else "no program runs"
    return [(at, "")]


def _machine_lines(status: Json, statistics: Json, recording: object) -> list[tuple[str, str]]:
    """How the ticks were kept, the link, and the recording."""
    latency = statistics["latency_us"]
    causes = ", ".join(
        f"{name.replace('_', ' ')} {count}" for name, count in statistics["missed_by_cause"].items() if count
    )
    lines = [
        (f"ticks missed {statistics['missed']}{f' ({causes})' if causes else ''}", ""),
        (
            f"ticks late by {latency['p50']:.0f} us, 1 in 100 by {latency['p99']:.0f}, at most {latency['max']:.0f}; "
            f"frames rejected {status['rejected_frames']}",
            "",
        ),
    ]
    wire = status.get("wire") or {}
    if wire.get("deadman_margin_ticks") is not None:
        load = "" if wire["bus_load"] is None else f"; bus load {wire['bus_load']:.0%}"
        margin, window = wire["deadman_margin_ticks"], wire["deadman_window_ticks"]
        # as the page's lamp has it
        tone = "" if margin > window / 2 else "warning" if margin > window / 5 else "bad"
        lines.append((f"deadman margin at least {margin} of {window} ticks{load}", tone))
    if isinstance(recording, dict):
        lamp = recording.get("lamp")
        tone = {"ok": "", "low": "warning"}.get(str(lamp), "bad")
        lines.append((f"recording {lamp}, {recording.get('free_mb', 0):.0f} MB free", tone))
    return lines


def _model_lines(observer: Json) -> list[tuple[str, str]]:
    """What the model beside the antenna lacks."""
    if observer.get("state") in (None, "off"):
        return []
    if observer["state"] != "watching":
        why = observer["problem"] or _UNWATCHED.get(observer["state"], observer["state"])
        return [(f"model {Path(observer['model']).name}: {why}", "")]
    told = []
    for axis, one in observer["axes"].items():
        rms, usual = ("nothing yet" if one[key] is None else f"{one[key]:.3g} N m" for key in ("rms_nm", "usual_nm"))
        said = {
            "changed": f"CHANGED: lacks {rms}, usual {usual}",
            "learning": f"lacks {rms}, learning what is usual",
        }.get(one["state"], f"lacks {rms}, as usual")
        told.append(f"{axis} {said}")
    changed = any(one["state"] == "changed" for one in observer["axes"].values())
    lines = [("beside the model: " + "; ".join(told), "bad" if changed else "")]
    for axis, one in observer["axes"].items():
        suspected = one.get("suspected")
        if suspected is not None:
            line = f"{axis} suspected: {suspected['text']}; confirm: gimbal-hil experiment {suspected['confirmed_by']}"
            lines.append((line, "warning"))
    return lines


def _number(value: float | None, width: int, decimals: int) -> str:
    return f"{'-':>{width}}" if value is None else f"{value:>+{width}.{decimals}f}"


def _degrees(radians: float | None, width: int, decimals: int) -> str:
    import math

    return f"{_number(None if radians is None else math.degrees(radians), width, decimals)}\u00b0"


def _bar(position: float | None, limits: Json) -> str:
    """Where a joint is between the stops of its travel, or half a turn either way where it has none; `|` is zero."""
    import math

    low, high = limits.get("position_low_rad"), limits.get("position_high_rad")
    ends = (-math.pi if low is None else low, math.pi if high is None else high)
    names = [f"{math.degrees(end):+.0f}\u00b0" for end in ends]
    cells = [" "] * (_WIDTH + 1)

    def place(angle: float) -> int:
        share = (angle - ends[0]) / max(ends[1] - ends[0], 1e-9)
        return round(min(max(share, 0.0), 1.0) * _WIDTH)

    if ends[0] <= 0.0 <= ends[1]:
        cells[place(0.0)] = "|"
    if position is not None:
        cells[place(position)] = "#"
    return f"{names[0]:>5} [{''.join(cells)}] {names[1]}"
