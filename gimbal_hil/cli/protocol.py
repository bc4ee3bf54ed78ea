"""`gimbal-hil protocol`: the wire definition for other programs and people."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from firmware_protocol.errors import EXIT_DONE, EXIT_NO, BadInputError
from gimbal_hil.cli.following import command_line, print_next


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
    force: Annotated[bool, typer.Option("--force", help="Overwrite FILE.")] = False,
) -> int:
    """Emit the wire definition as DBC, C header or documentation, or check that the kept files are what is emitted."""
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
