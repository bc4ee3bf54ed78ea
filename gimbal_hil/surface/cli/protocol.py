"""`gimbal-hil protocol`: the wire definition for other programs and people."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from firmware_protocol.errors import EXIT_DONE, EXIT_NO, BadInputError
from gimbal_hil.surface.cli.completion import model_names
from gimbal_hil.surface.cli.next_line import command_line, print_next


def command(
    emit: Annotated[
        str | None, typer.Option(help="dbc, c (header), docs (Markdown), mail, messages or field_words (Python).")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="File to write (to compare with, with --check) instead of printing.")
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Compare with the file that is kept: exit 1 when it differs.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is there.")] = False,
    device: Annotated[
        Path | None, typer.Option(help="Write the C device into this folder, with the settings of --config's antenna.")
    ] = None,
    config: Annotated[
        Path | None, typer.Option(help="With --device: configuration; its rate, and its antenna unless --model.")
    ] = None,
    model: Annotated[
        str | None,
        typer.Option(metavar="MODEL", autocompletion=model_names, help="With --device: model, a file or shipped name."),
    ] = None,
) -> int:
    """Emit the wire definition as DBC, C header or documentation, check that the kept files are what is emitted, or
    write the C device with an antenna's settings.
    """
    if device is not None:
        return _hand_over(device, config, model, force)
    from firmware_protocol.emit import FORMS, committed_path
    from firmware_protocol.emit import emit as emit_form

    if check:
        forms = list(FORMS) if emit is None else [emit]
        if out is not None and emit is None:
            raise BadInputError("--out", "a file can be compared with one form only", "--emit FORM beside it")
        outcomes = [_matches(emit_form(form), out or committed_path(form)) for form in forms]
        return EXIT_DONE if all(outcomes) else EXIT_NO
    if emit is None:
        raise BadInputError("--emit", "nothing to emit", ", ".join(FORMS) + ", or --check")
    text = emit_form(emit)
    if out is None:
        sys.stdout.write(text)
        return EXIT_DONE
    if out.exists() and not force and out.read_bytes() != text.encode():
        raise BadInputError(str(out), "the file exists and differs", "another name, or --force")
    try:
        out.write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise BadInputError(str(out), error.strerror or str(error), "a file that can be written") from error
    print_next(command_line("protocol", "--check", emit=emit, out=out))
    return EXIT_DONE


def _hand_over(folder: Path, config: Path | None, model: str | None, force: bool) -> int:
    """The C device for an antenna that the configuration or the model describes."""
    from gimbal_hil.loop.settings import EmbeddedAntenna, load_settings, shipped_settings
    from sim_backend.firmware import write_device
    from sim_backend.model import model_named

    settings = load_settings(config) if config else shipped_settings()
    if model is None:
        if not isinstance(settings.link, EmbeddedAntenna):
            raise BadInputError("--model", "no antenna is described: the link is a real one", "--model with its model")
        model = settings.link.embedded.model
    antenna = model_named(model)
    for path in write_device(folder, antenna, settings.rate_hz, force=force):
        print(path)
    print_next("gimbal-hil conformance --link c")
    return EXIT_DONE


def _matches(text: str, path: Path) -> bool:
    kept = path.read_bytes() if path.is_file() else None
    if kept == text.encode():
        print(f"{path}: is what the schema emits")
        return True
    print(
        f"{path}: "
        + (
            "is missing"
            if kept is None
            else f"differs from line {_first_difference(text, kept.decode(errors='replace'))} on"
        )
    )
    return False


def _first_difference(text: str, kept: str) -> int:
    ours, theirs = text.splitlines(), kept.splitlines()
    pairs = enumerate(zip(ours, theirs, strict=False), start=1)
    return next((number for number, (left, right) in pairs if left != right), min(len(ours), len(theirs)) + 1)
