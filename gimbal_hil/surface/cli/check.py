"""`gimbal-hil check`: files that people write, checked by the loaders that read them; JSON schemas for editors."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimbal_hil.surface.cli.log_options import LogOptions

if TYPE_CHECKING:
    from gimbal_hil.surface.checking import Checked

#: options that take several values after one another
MANY_VALUED = ("--column",)


def command(
    *,
    files: Annotated[
        list[Path] | None,
        typer.Argument(metavar="FILE...", help="YAML files, tables, run folders, or a folder of YAML files."),
    ] = None,
    axes: Annotated[
        str | None,
        typer.Option(metavar="NAME,NAME", help="Axes of plans and tables; else those of a model here."),
    ] = None,
    reading: LogOptions,
    schema: Annotated[
        str | None,
        typer.Option(
            metavar="KIND", help="Print the JSON schema of a configuration, model, plan or changed.json instead."
        ),
    ] = None,
    junit: Annotated[Path | None, typer.Option(metavar="FILE", help="The findings as JUnit XML too (CI).")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the findings as one JSON object.")] = False,
) -> int:
    """Say what each file is and everything that is wrong with it: file, key, what was expected.

    Ends with 0 when all are good, with 1 when one is not, with 2 when one cannot be read at all.
    """
    import json

    from firmware_protocol.errors import EXIT_DONE, EXIT_NO, BadInputError
    from gimbal_hil.pages.report import Case, write_junit
    from gimbal_hil.surface.checking import check_files
    from gimbal_hil.surface.cli.following import after_check
    from gimbal_hil.surface.cli.next_line import print_next

    if schema is not None:
        return _print_schema(schema)
    if not files:
        raise BadInputError("FILE", "is missing", "files or a folder to check, or --schema KIND")
    names = tuple(name for name in (axes or "").split(",") if name)
    checked = check_files([file for given in files for file in _spread(given)], names, reading.reading())
    good = all(not one.faults for one in checked)
    if junit is not None:
        cases = [Case(str(one.path), "\n".join(_lines(one)), bool(one.faults)) for one in checked]
        write_junit(junit, "gimbal-hil check", cases)
    if as_json:
        print(json.dumps({"good": good, "files": [one.as_dict() for one in checked]}))
    else:
        print("\n".join(line for one in checked for line in _lines(one)))
        guessed = list(dict.fromkeys(word for one in checked for word in one.reads_as))
        if reading.column or not any(one.is_strange for one in checked):
            print_next(after_check(files, checked, reading.column or guessed, reading.repairs))
    return EXIT_DONE if good else EXIT_NO


def _print_schema(name: str) -> int:
    from firmware_protocol.errors import EXIT_DONE, BadInputError
    from gimbal_hil.surface.checking import ANSWER_SCHEMAS, SCHEMA_KINDS, answer_schema_text, schema_text

    if name in ANSWER_SCHEMAS:
        print(answer_schema_text(name), end="")
        return EXIT_DONE
    kind = next((kind for kind in SCHEMA_KINDS if kind.value == name), None)
    if kind is None:
        raise BadInputError("--schema", f"no kind {name!r}", ", ".join([*SCHEMA_KINDS, *ANSWER_SCHEMAS]))
    print(schema_text(kind), end="")
    return EXIT_DONE


def _spread(given: Path) -> list[Path]:
    """A folder that is no run stands for the YAML files in it."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.data.containers import container_of
    from gimbal_hil.data.runs import RUN_FILE

    if not given.is_dir() or (given / RUN_FILE).exists() or container_of(given) is not None:
        return [given]
    found = sorted(path for path in given.iterdir() if path.suffix in (".yaml", ".yml"))
    if not found:
        raise BadInputError(str(given), "holds no YAML file", "a run folder, or one with configuration, model or plans")
    return found


def _lines(one: Checked) -> list[str]:
    if not one.faults:
        return [f"good   {one.path}: {one.kind}: {one.text}"]
    return [f"wrong  {fault}" for fault in one.faults]
