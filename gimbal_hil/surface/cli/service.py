"""`gimbal-hil service`: files for a machine that runs the daemon for good."""

from __future__ import annotations

import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from firmware_protocol.places import require_new


class ServiceAction(StrEnum):
    """What is written."""

    INSTALL = "install"
    CONTAINER = "container"
    GRAFANA = "grafana"
    MAN = "man"


_MANUAL = "gimbal-hil.1"
_NAMES = {ServiceAction.CONTAINER: "Containerfile", ServiceAction.GRAFANA: "gimbal-hil-grafana.json"}


def command(
    action: Annotated[
        ServiceAction,
        typer.Argument(help="install: systemd unit; container: container file; grafana: dashboard; man: pages."),
    ],
    config: Annotated[Path | None, typer.Option(help="install, container: the daemon's configuration file.")] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder to write into; without it the system's (install), or here."),
    ] = None,
    runs: Annotated[Path, typer.Option(help="install: folder for the run folders.")] = Path("/var/lib/gimbal-hil"),
    user: Annotated[str | None, typer.Option(help="install: who runs it; without it you.")] = None,
    page: Annotated[int | None, typer.Option(help="install: port of live page and metrics.", min=1, max=65535)] = None,
    watchdog: Annotated[int, typer.Option(help="install: seconds without a tick until a restart.", min=2)] = 10,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is there.")] = False,
) -> int:
    """Write what a machine needs to run the daemon for good: a systemd unit (told when ticks run, watched, with
    real-time limits and few rights), a container file, a Grafana dashboard for /metrics, or man pages.
    """
    from firmware_protocol.errors import EXIT_DONE, BadInputError
    from gimbal_hil.surface.cli.next_line import print_next

    if action is ServiceAction.INSTALL:
        files, following = _unit(config, out, runs, user, page, watchdog)
    elif action is ServiceAction.MAN:
        files, following = _manual(out or Path("man1"))
    else:
        from gimbal_hil.surface.deployment import container_file, grafana_dashboard

        text = grafana_dashboard() if action is ServiceAction.GRAFANA else container_file(_inside(config))
        files, following = {(out or Path()) / _NAMES[action]: text}, "gimbal-hil daemon --page 8765"
    for path in files:
        require_new(path.parent, force, path.name, instead="another folder")
    for path, text in files.items():
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        except OSError as error:
            raise BadInputError(str(path), error.strerror or "cannot be written", "root, or --out DIR") from None
    print("\n".join(map(str, files)) if len(files) < 4 else f"{len(files)} pages in {next(iter(files)).parent}")
    print_next(following)
    return EXIT_DONE


def _unit(
    config: Path | None, out: Path | None, runs: Path, user: str | None, page: int | None, watchdog: int
) -> tuple[dict[Path, str], str]:
    import getpass

    from firmware_protocol.errors import BadInputError
    from gimbal_hil.loop.settings import load_settings
    from gimbal_hil.surface.cli.next_line import command_line
    from gimbal_hil.surface.deployment import UNIT_NAME, UnitChoice, unit_text

    if config is None:
        raise BadInputError("--config", "is missing", "the daemon's configuration file")
    load_settings(config)
    program = Path(sys.executable).with_name("gimbal-hil")
    folder, manuals = (out, out) if out else (Path("/etc/systemd/system"), Path("/usr/local/share/man/man1"))
    manual = folder.absolute().joinpath(_MANUAL).as_uri() if out else "man:gimbal-hil(1)"
    choice = UnitChoice(program, config.absolute(), runs.absolute(), user or getpass.getuser(), page, watchdog, manual)
    # systemd runs no program whose own path needs escapes, and a line of a unit ends where it ends
    for path, unread in ((choice.program, "\"'$%\\ \n"), (choice.config, "\n"), (choice.runs, "\n$")):
        if set(str(path)) & set(unread):
            raise BadInputError(str(path), "has a character that a unit would read otherwise", "a plain path")
    files = {folder / UNIT_NAME: unit_text(choice), manuals / _MANUAL: _own_page()}
    return files, command_line("doctor", config=config)


def _own_page() -> str:
    from firmware_protocol.version import __version__
    from gimbal_hil.surface.cli.app import overview
    from gimbal_hil.surface.deployment import manual_page

    line = "hardware-in-the-loop controller service and virtual antenna"
    return manual_page("gimbal-hil", line, overview(), __version__, _today())


def _today() -> str:
    from datetime import UTC, datetime

    return datetime.now(UTC).date().isoformat()


def _manual(folder: Path) -> tuple[dict[Path, str], str]:
    from firmware_protocol.version import __version__
    from gimbal_hil.surface.cli.commands import COMMANDS
    from gimbal_hil.surface.cli.completion import help_of
    from gimbal_hil.surface.deployment import manual_page

    files = {folder / _MANUAL: _own_page()}
    for name, one in COMMANDS.items():
        page = manual_page(f"gimbal-hil {name}", one.line, help_of(name), __version__, _today())
        files[folder / f"gimbal-hil-{name}.1"] = page
    return files, "gimbal-hil doctor"


def _inside(config: Path | None) -> str:
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.loop.settings import load_settings

    if config is None:
        return "/src/config/virtual_antenna.yaml"
    load_settings(config)
    here = Path.cwd().resolve()
    if not config.resolve().is_relative_to(here):
        raise BadInputError("--config", f"{config} is not copied into the container", f"a file below {here}")
    return f"/src/{config.resolve().relative_to(here).as_posix()}"
