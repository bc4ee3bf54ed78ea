"""The `gimbal-hil` command: finds each command's module by name and turns errors into one line and an exit code."""

from __future__ import annotations

import difflib
import errno
import itertools
import os
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext, suppress
from functools import wraps
from typing import NoReturn

from firmware_protocol.errors import EXIT_BAD_INPUT, EXIT_DONE, EXIT_INTERRUPTED, BadInputError, GimbalHilError
from firmware_protocol.version import __version__
from gimbal_hil.surface.cli.commands import COMMANDS, GROUPS, function_of
from gimbal_hil.surface.cli.help_text import help_text

INTERRUPTED = "interrupted"
#: set by a shell that asks for completions
COMPLETE = "_GIMBAL_HIL_COMPLETE"
#: as `documents.LARGEST_NUMBER`, which --help must not import
_LARGEST_NUMBER = 1e15


def main(arguments: list[str] | None = None) -> None:
    """Entry point of the `gimbal-hil` command; ends the process with the exit codes of docs/reference/commands.md."""
    words = sys.argv[1:] if arguments is None else arguments
    _with_streams()
    try:
        code = _answer(words)
        # here, where a reader that has gone or a full disk can still be answered for
        sys.stdout.flush()
    except BrokenPipeError:
        code = without_a_reader()
    except KeyboardInterrupt:
        # while something was imported, before any command had a word of its own
        _fail(INTERRUPTED, EXIT_INTERRUPTED)
    except OSError as error:
        _fail(f"error: {_of_the_system(error)}", EXIT_BAD_INPUT)
    sys.exit(code)


def _answer(words: list[str]) -> int:
    if COMPLETE in os.environ or words[:1] in (["--install-completion"], ["--show-completion"]):
        from gimbal_hil.surface.cli.completion import complete

        try:
            return complete(words)
        except Exception as error:
            # click's own errors, which are not imported for `--help`
            if not hasattr(error, "format_message"):
                raise
            _fail(f"error: {' '.join(error.format_message().split())}", EXIT_BAD_INPUT)
    if not words or words[0] in ("--help", "-h", "help"):
        print(overview())
        return EXIT_DONE
    if words[0] == "--version":
        print(f"gimbal-hil {__version__}")
        return EXIT_DONE
    if words[0] not in COMMANDS:
        near = difflib.get_close_matches(words[0], COMMANDS, 1)
        _fail(
            f"error: no command {words[0]!r}" + (f"; did you mean {near[0]!r}?" if near else "; see gimbal-hil --help"),
            EXIT_BAD_INPUT,
        )
    return run(words[0], words[1:])


def run(name: str, arguments: list[str]) -> int:
    """Import one command's module, run it and answer its exit code; errors become one line on stderr.

    What the system refuses (OSError) is left to the caller.
    """
    import typer
    import typer.main

    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)
    try:
        loaded, answer = function_of(name)
        app.command(name=name)(_guarded(answer, COMMANDS[name].compiles))
        # what stands behind "--" is a name, whatever it looks like
        if "--help" in itertools.takewhile(lambda word: word != "--", arguments):
            print(help_text(typer.main.get_command(app), name))
            return EXIT_DONE
        arguments = _repeated(arguments, getattr(loaded, "MANY_VALUED", ()))
        code = app(arguments, prog_name=f"gimbal-hil {name}", standalone_mode=False)
    except GimbalHilError as error:
        _fail(f"error: {error}", error.exit_code)
    except (KeyboardInterrupt, typer.Abort):
        _fail(INTERRUPTED, EXIT_INTERRUPTED)
    except typer.Exit as done:
        return int(done.exit_code)
    except OSError:
        raise
    except MemoryError:
        _fail(
            "error: there is not enough memory for this; expected a smaller file, a shorter run or a larger machine",
            EXIT_BAD_INPUT,
        )
    except Exception as error:
        if _of_a_damaged_kernel(error):
            from firmware_protocol.kernel_cache import cache_directory

            problem = f"a compiled kernel there cannot be read ({error})"
            _fail(
                f"error: {cache_directory()}: {problem}; expected the folder deleted: all is compiled anew",
                EXIT_BAD_INPUT,
            )
        if not hasattr(error, "format_message"):
            raise
        _fail(f"error: {error.format_message().replace('Value error, ', '')}", EXIT_BAD_INPUT)
    return code if isinstance(code, int) else EXIT_DONE


def _guarded(command: Callable[..., int], compiles: bool) -> Callable[..., int]:
    """The command with a line for Ctrl-C (typer would end it without a message), given finite numbers only; what it
    compiles is shown.
    """

    @wraps(command)
    def saying(*arguments: object, **named: object) -> int:
        for name, value in named.items():
            if isinstance(value, float) and not abs(value) <= _LARGEST_NUMBER:
                option = f"--{name.replace('_', '-')}"
                raise BadInputError(
                    option, f"{value:g} is no number that can be worked with", f"a size of at most {_LARGEST_NUMBER:g}"
                )
        try:
            with _shown(compiles):
                return command(*arguments, **named)
        except KeyboardInterrupt:
            print(INTERRUPTED, file=sys.stderr)
            return EXIT_INTERRUPTED
        except BrokenPipeError:
            # typer would make it 1, which is the answer "no"
            return without_a_reader()

    return saying


def _shown(compiles: bool) -> AbstractContextManager[None]:
    if not compiles:
        return nullcontext()
    # numba, which such a command loads anyway
    from gimbal_hil.surface.cli.compiling import compiling_shown

    return compiling_shown()


def _repeated(arguments: list[str], options: tuple[str, ...]) -> list[str]:
    """`--log a b` as `--log a --log b`, for a command's options that take many values."""
    spread: list[str] = []
    current = ""
    for word in arguments:
        if word.startswith("-") and len(word) > 1:
            current = word
        elif current in options and spread[-1] != current:
            spread.append(current)
        spread.append(word)
    return spread


def overview() -> str:
    """What `gimbal-hil --help` says."""
    width = max(map(len, COMMANDS))
    table = "\n\n".join(
        "\n".join([f"{group}:", *(f"  {name:<{width}}  {one.line}" for name, one in commands.items())])
        for group, commands in GROUPS.items()
    )
    return f"""Usage: gimbal-hil COMMAND [OPTIONS]

  Controller service and virtual antenna for a two-axis gimballed airborne antenna.

{table}

Each command explains itself with --help; gimbal-hil --install-completion has the shell complete them.
Exit codes: 0 done and good, 1 done with a negative result, 2 bad input, 3 safety stop, 130 interrupted."""


def _with_streams() -> None:
    """A stream that was closed before the start (`<&-`) is the empty one: nothing is read, nothing said."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115


def _of_a_damaged_kernel(error: Exception) -> bool:
    """Whether it was raised where compiled code is read from the disk: a file there was cut off."""
    trace = error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_globals.get("__name__") == "numba.core.caching":
            return True
        trace = trace.tb_next
    return False


def without_a_reader() -> int:
    """Whoever read the output has seen enough (`| head`) or is gone: nothing more is written, and that is no error."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            os.dup2(nowhere, stream.fileno())
    return EXIT_DONE


def _of_the_system(error: OSError) -> str:
    """What the system refused, in one line: a name that is too long, a full disk, no more open files."""
    words = error.strerror or str(error)
    place = str(error.filename) if error.filename is not None else ""
    shown = place if len(place) <= 200 else f"{place[:100]}...{place[-60:]}"
    advice = {
        errno.ENAMETOOLONG: "expected a name of at most 255 characters",
        errno.EMFILE: "expected a larger limit of open files (ulimit -n 256)",
        errno.ENOSPC: "expected free space on that disk",
        errno.ENOENT: "" if place else "expected a working folder that is still there (cd)",
    }.get(error.errno or 0)
    return ": ".join(part for part in (shown, words) if part) + (f"; {advice}" if advice else "")


def _fail(line: str, code: int) -> NoReturn:
    print(line, file=sys.stderr)
    sys.exit(code)
