"""`gimbal-hil daemon`: the fixed-rate control daemon, and a word to one that runs."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimbal_hil.surface.cli.app import without_a_reader

if TYPE_CHECKING:
    from gimbal_hil.realtime.daemon import DaemonReport
    from sim_backend.model import AntennaModel


@dataclass(frozen=True)
class DaemonChoice:
    """How a daemon runs and what it serves."""

    duration: Annotated[float | None, typer.Option(help="Seconds to run; without it until stopped.", min=0.0)] = None
    lockstep: Annotated[
        bool,
        typer.Option(
            "--lockstep",
            help="Virtual time: as fast as the machine allows; over a link an antenna in lockstep is at its other end.",
        ),
    ] = False
    answer_within: Annotated[
        float,
        typer.Option(help="In lockstep over a link: seconds that an answer may take; 0 waits for ever.", min=0.0),
    ] = 30.0
    page: Annotated[
        int | None, typer.Option(help="Serve live page and metrics on this local port (0: any).", min=0, max=65535)
    ] = None
    spin_us: Annotated[
        float,
        typer.Option(help="Wait the last microseconds of a period awake: less latency, more load.", min=0.0, max=1e5),
    ] = 50.0
    wait: Annotated[
        bool, typer.Option("--wait", help="Wait for the link even where it looks wrong, as a device that is not there.")
    ] = False
    then: Annotated[
        str | None,
        typer.Option(
            metavar="MODEL@SECONDS",
            help="The virtual antenna in this process follows another model from then on: an effect that sets in.",
        ),
    ] = None
    end_with: Annotated[
        int | None,
        typer.Option(metavar="PID", help="End as by SIGTERM when this process, which started the daemon, is gone."),
    ] = None


def command(
    *,
    config: Annotated[
        Path | None, typer.Option(help="Configuration file; without it the shipped virtual antenna.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Run folder to record into; without it a new one below ./runs.")
    ] = None,
    how: DaemonChoice,
    force: Annotated[bool, typer.Option("--force", help="Overwrite a run folder.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")] = False,
    send: Annotated[
        str | None,
        typer.Option(help="Send one request (JSON) to the daemon that records into --run, print its answer."),
    ] = None,
    run: Annotated[Path | None, typer.Option(help="With --send: the run folder of that daemon.")] = None,
) -> int:
    """Run the fixed-rate control daemon on the link that the configuration names.

    Ctrl-C or SIGTERM switches torque off with the next tick, lets the drive stop the axes, writes the log and ends with
    130.
    """
    from firmware_protocol.errors import BadInputError

    if send is not None:
        if run is None:
            raise BadInputError("--send", "does not say to whom", "--run with the run folder of a running daemon")
        return _send(send, run)
    from gimbal_hil.loop.settings import load_settings, shipped_settings
    from gimbal_hil.loop.timing import wall_clock_utc
    from gimbal_hil.realtime.daemon import DaemonOptions, run_daemon

    if how.end_with is not None:
        from gimbal_hil.knowledge.executor import end_with_parent

        end_with_parent(how.end_with)
    settings = load_settings(config) if config else shipped_settings()
    folder = out or Path("runs") / f"daemon-{wall_clock_utc()[:19].replace(':', '').replace('-', '')}"
    options = DaemonOptions(
        folder,
        force,
        how.duration,
        how.lockstep,
        how.answer_within,
        how.spin_us,
        how.page,
        wait=how.wait,
        then=_then(how.then),
    )
    report = run_daemon(settings, options)
    try:
        _tell(report, as_json)
        sys.stdout.flush()
    except OSError:
        # the terminal was closed (ssh): the run folder says how it ended, and so does the exit code
        without_a_reader()
    return report.ending.exit_code


def _tell(report: DaemonReport, as_json: bool) -> None:
    import json

    from gimbal_hil.realtime.daemon import summary_lines
    from gimbal_hil.surface.cli.following import after_daemon
    from gimbal_hil.surface.cli.next_line import print_next

    if as_json:
        print(json.dumps(report.as_dict()))
    else:
        print("\n".join(summary_lines(report)))
        print_next(after_daemon(report.run, report.ending.exit_code))


def _then(text: str | None) -> tuple[AntennaModel, float] | None:
    from firmware_protocol.errors import BadInputError
    from sim_backend.model import model_named

    if text is None:
        return None
    name, _, after = text.rpartition("@")
    if not name or not after.replace(".", "", 1).isdigit():
        raise BadInputError("--then", f"is {text!r}", "MODEL@SECONDS, as in cogging.yaml@20")
    return model_named(name), float(after)


def _send(text: str, run: Path) -> int:
    import json

    from firmware_protocol.documents import json_line
    from firmware_protocol.errors import EXIT_DONE, EXIT_NO, BadInputError
    from gimbal_hil.realtime.operator import OperatorClient, RequestRefusedError

    expected = 'a JSON object such as {"command": "status"}'
    request = json_line(text, "--send", expected)
    name = request.pop("command", None)
    if not isinstance(name, str):
        raise BadInputError("--send: command", "is missing" if name is None else "is no text", expected)
    with OperatorClient(run) as client:
        try:
            print(json.dumps(client.when_ready(name, **request)))
        except RequestRefusedError as refusal:
            print(json.dumps({"ok": False, "error": str(refusal)}))
            return EXIT_NO
    return EXIT_DONE
