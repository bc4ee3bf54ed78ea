"""`gimbal-hil watch`: a running daemon in a terminal, over ssh too. It asks the service process, never the loop."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

_WIDTH = 24
_ACTS = {"s": "stop", "b": "adjust_back", "n": "learn_anew"}
_KEYS = "keys: s stop, b gains and limits back to the configuration, n learn anew what the model lacks, q leave"


def command(
    run: Annotated[
        Path | None,
        typer.Argument(metavar="RUN", help="Run folder of the daemon; without it the newest below ./runs."),
    ] = None,
    every: Annotated[float, typer.Option(metavar="SECONDS", help="Time between two looks.", min=0.05)] = 0.25,
    once: Annotated[bool, typer.Option("--once", help="One look, then end (as for scripts).")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="The daemon's own answer, one JSON object a look.")] = False,
) -> int:
    """Show state, axes, torque, deadline misses and recording of a running daemon, until it ends or Ctrl-C.

    In a terminal one key acts: s stops, b takes gains and limits back to the configuration, n takes what the
    model lacks from now on as usual, q leaves.
    """
    import json
    import sys

    from firmware_protocol.errors import EXIT_DONE, LinkError, shown
    from gimbal_hil.realtime.operator import OperatorClient
    from gimbal_hil.surface.cli.following import after_daemon, print_next
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
                lines = [shown(line) for line in status_lines(answer)]
                if in_place:
                    lines.append(_KEYS)
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


def status_lines(answer: dict[str, Any]) -> list[str]:
    """What a `status` answer says, a line each."""
    status = answer["status"]
    statistics = status["statistics"]
    latency = statistics["latency_us"]
    fault = status["drive_fault"]
    said = f" ({status['drive_complaint']})" if status.get("drive_complaint") else ""
    drive = status["drive_state"] or "not heard"
    if status["link"] == "lost" and status["drive_state"]:
        drive += ", last heard"
    state = f"{status['host_state']:<14} drive {drive:<24} link {status['link']}"
    lines = [
        f"tick {status['tick']:>10}   {status['time_ns'] / 1e9:>10.1f} s   host {state}",
        f"fault: {fault}{said}"
        if fault not in (None, "none")
        else f"segment {status['segment']}, last cause {status['cause']}",
    ]
    for axis, position in status["position_rad"].items():
        rate, torque = status["rate_rad_s"][axis], status["torque_nm"][axis]
        bar = _bar(position)
        lines.append(
            f"{axis:<12} {status['mode'][axis]:<14} {_number(position, 'rad')} {bar} {_number(rate, 'rad/s')} "
            f"{_number(torque, 'N m')}"
        )
    pointing = status.get("pointing") or {}
    if pointing.get("state", "off") != "off":
        lines.append(f"pointing: {pointing['state']}, {'muted' if pointing['muted'] else 'not muted'}")
    lines += _model_lines(status.get("observer") or {})
    if status.get("adjusted"):
        lines.append("not as configured: " + ", ".join(status["adjusted"]))
    causes = ", ".join(f"{name} {count}" for name, count in statistics["missed_by_cause"].items() if count)
    lines.append(
        f"ticks missed {statistics['missed']}{f' ({causes})' if causes else ''}; late by p50 {latency['p50']:.0f}, "
        f"p99 {latency['p99']:.0f}, most {latency['max']:.0f} us; frames rejected {status['rejected_frames']}"
    )
    wire = status.get("wire") or {}
    if wire.get("deadman_margin_ticks") is not None:
        load = "" if wire["bus_load"] is None else f"; bus load {wire['bus_load']:.0%}"
        margin, window = wire["deadman_margin_ticks"], wire["deadman_window_ticks"]
        lines.append(f"deadman margin at least {margin} of {window} ticks{load}")
    recording = answer.get("recording")
    if isinstance(recording, dict):
        lines.append(f"recording {recording.get('lamp')}, {recording.get('free_mb', 0):.0f} MB free")
    return lines


def _model_lines(observer: dict[str, Any]) -> list[str]:
    """What the model beside the antenna lacks."""
    if observer.get("state") in (None, "off"):
        return []
    if observer["state"] != "watching":
        return [f"model {Path(observer['model']).name}: {observer['problem'] or observer['state']}"]
    told = []
    for axis, one in observer["axes"].items():
        rms, usual = ("-" if one[key] is None else f"{one[key]:.3g} N m" for key in ("rms_nm", "usual_nm"))
        said = f"CHANGED: lacks {rms}, usual {usual}" if one["state"] == "changed" else f"{one['state']}, {rms}"
        told.append(f"{axis} {said}")
    return ["against model: " + "; ".join(told)]


def _number(value: float | None, unit: str) -> str:
    return f"{'-':>9} {unit:<5}" if value is None else f"{value:>+9.4f} {unit:<5}"


def _bar(position: float | None) -> str:
    """Where a joint is between half a turn either way; the middle is zero."""
    import math

    cells = [" "] * (_WIDTH + 1)
    cells[_WIDTH // 2] = "|"
    if position is not None:
        place = round((min(max(position / math.pi, -1.0), 1.0) + 1.0) * _WIDTH / 2)
        cells[place] = "#"
    return f"[{''.join(cells)}]"
