"""Requests to a running daemon from a terminal: set, stop, quick-stop, reset, shut-down."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from firmware_protocol.json_object import Json

if TYPE_CHECKING:
    from gimbal_hil.realtime.operator import OperatorClient

Run = Annotated[
    Path | None, typer.Option(metavar="RUN", help="Run folder of the daemon; without it the newest one below ./runs.")
]
Place = Annotated[Path | None, typer.Argument(metavar="RUN", help="Run folder of the daemon, as with --run.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print the daemon's answer as one JSON object.")]
_MODES = {"position": "rad", "rate": "rad/s", "inertial_rate": "rad/s", "torque": "N m", "pointing": "rad"}


def set_axes(
    values: Annotated[
        list[str], typer.Argument(metavar="AXIS=VALUE...", help="As in outer=0.5 inner=-20deg: names of your model.")
    ],
    mode: Annotated[
        str, typer.Option(help="position (rad), rate or inertial_rate (rad/s), torque (N m), pointing (rad, in space).")
    ] = "position",
    over: Annotated[
        float, typer.Option(metavar="SECONDS", help="Move smoothly for so long; 0: at once.", min=0.0)
    ] = 0.0,
    attended: Annotated[
        bool,
        typer.Option(
            "--attended",
            help="Stay here; the motion ends, braked to rest, with this command: Ctrl-C, a closed terminal, a kill.",
        ),
    ] = False,
    run: Run = None,
    as_json: AsJson = False,
) -> int:
    """Have axes go to values and hold them; an axis that is not named stays where it is (in rate and torque: zero).

    Without --attended a set-point outlives this command: `stop` ends it.
    """
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.surface.cli.next_line import command_line

    if mode not in _MODES:
        raise BadInputError("--mode", f"no mode {mode!r}", ", ".join(_MODES))
    folder = daemon_run(run)
    with _client(folder) as client:
        status = client.request("status")["status"]
        axes = list(status["position_rad"])
        wanted = _values(values, axes, _MODES[mode])
        standing = status["position_rad"] if mode == "position" else dict.fromkeys(axes, 0.0)
        if mode == "pointing" and len(wanted) < len(axes):
            raise BadInputError("pointing", "a direction has two angles", f"values for {' and '.join(axes)}")
        for axis in axes:
            if wanted.get(axis, standing[axis]) is None:
                raise BadInputError(f"{axis}=", "its position is not known yet", f"a value for {axis} too")
        targets = {axis: float(wanted.get(axis, standing[axis])) for axis in axes}
        answer = client.when_ready("set_point", mode=mode, over_s=over, lease=attended, **targets)
        said = ", ".join(f"{axis} to {_told(value, _MODES[mode])}" for axis, value in targets.items())
        told = _tell(answer, f"{said} from tick {answer['tick']}", command_line("watch", folder), as_json)
        if attended:
            _attend(client, int(answer["tick"]))
    return told


def _attend(client: OperatorClient, since_tick: int) -> None:
    """Stay until somebody else ends the motion, which is told; SafetyStopError where a guard did."""
    import sys

    from firmware_protocol.errors import SafetyStopError
    from gimbal_hil.loop.host import HostCause, word_of

    print("this command keeps the motion going: Ctrl-C brakes to rest", file=sys.stderr, flush=True)

    def ends(event: Json) -> bool:
        data = event.get("data", {})
        return bool(event.get("tick", 0) >= since_tick and data.get("code") == "state" and data["from"] == "active")

    while (ended := client.wait_for(ends, 60.0)) is None:
        pass
    print(ended["text"], file=sys.stderr)
    if ended["data"]["cause"] != word_of(HostCause.OPERATOR):
        raise SafetyStopError(f"the host went {ended['text']}")


def stop(place: Place = None, run: Run = None, as_json: AsJson = False) -> int:
    """Brake both axes to rest under control, then torque off; the daemon stays connected."""
    return _plain("stop", "braking to rest", _meant(place, run), as_json)


def quick_stop(place: Place = None, run: Run = None, as_json: AsJson = False) -> int:
    """The drive brakes both axes by itself, with torque, and holds them until it is switched off; left by `reset`."""
    return _plain("quick_stop", "quick stop", _meant(place, run), as_json, "reset")


def reset(place: Place = None, run: Run = None, as_json: AsJson = False) -> int:
    """Leave a fault and connect anew; torque stays off until the next motion is requested."""
    return _plain("fault_reset", "fault reset asked for", _meant(place, run), as_json)


def shut_down(place: Place = None, run: Run = None, as_json: AsJson = False) -> int:
    """Brake to rest, then end the daemon with its log complete."""
    return _plain("shut_down", "shutting down", _meant(place, run), as_json, "replay")


def _meant(place: Path | None, run: Path | None) -> Path | None:
    """The one folder that was given; BadInputError for two, of which one daemon would go on moving."""
    from firmware_protocol.errors import BadInputError

    if place is not None and run is not None and place.resolve() != run.resolve():
        raise BadInputError(f"--run {run}", f"is not {place}, which was given as well", "one run folder")
    return run or place


def daemon_run(run: Path | None) -> Path:
    """The run folder of the daemon meant: the one given, else the newest below ./runs at whose door one listens."""
    from firmware_protocol.errors import BadInputError

    if run is not None:
        return run
    from gimbal_hil.realtime.operator import Door

    doors = sorted(Path("runs").glob("*/operator.json"), key=lambda path: path.stat().st_mtime, reverse=True)
    # a daemon that was killed leaves its door behind
    alive = next((door.parent for door in doors if Door.is_open(door.parent)), None)
    if alive is None:
        raise BadInputError(
            "--run", "no running daemon has its folder below ./runs", "the run folder of one, or gimbal-hil daemon"
        )
    return alive


def _plain(name: str, said: str, run: Path | None, as_json: bool, following: str = "watch") -> int:
    from gimbal_hil.surface.cli.next_line import command_line

    folder = daemon_run(run)
    with _client(folder) as client:
        answer = client.request(name)
    follow = command_line("reset", run=folder) if following == "reset" else command_line(following, folder)
    return _tell(answer, f"{said}, tick {answer.get('tick', '-')}", follow, as_json)


def _client(folder: Path) -> OperatorClient:
    from gimbal_hil.realtime.operator import OperatorClient

    return OperatorClient(folder)


def _told(value: float, unit: str) -> str:
    """A set-point in its unit, an angle in degrees too."""
    import math

    more = f" ({math.degrees(value):.5g}\u00b0{unit.removeprefix('rad')})" if unit.startswith("rad") else ""
    return f"{value:.5g} {unit}{more}"


def _values(words: list[str], axes: list[str], unit: str) -> dict[str, float]:
    """Numbers by axis in the mode's unit; `30deg` (`30deg/s`) is taken where that is an angle."""
    import math

    from firmware_protocol.errors import BadInputError

    found: dict[str, float] = {}
    for word in words:
        axis, _, text = word.partition("=")
        if axis not in axes:
            raise BadInputError(word, f"no axis {axis!r}", " ".join(f"{name}=VALUE" for name in axes))
        degrees = unit.replace("rad", "deg")
        factor = math.radians(1.0) if degrees != unit and text.endswith(degrees) else 1.0
        number = text.removesuffix(degrees if factor != 1.0 else unit)
        try:
            found[axis] = factor * float(number)
        except ValueError:
            found[axis] = math.nan
        if not math.isfinite(found[axis]):
            expected = f"a number in {unit}, as in {axis}=0.5" + ("" if degrees == unit else f" or {axis}=30{degrees}")
            raise BadInputError(word, f"{text!r} is no number", expected)
    return found


def _tell(answer: Json, said: str, following: str, as_json: bool) -> int:
    import json

    from firmware_protocol.errors import EXIT_DONE
    from gimbal_hil.surface.cli.next_line import print_next

    print(json.dumps(answer) if as_json else said)
    if not as_json:
        print_next(following)
    return EXIT_DONE
