"""Completion for bash, zsh, fish and PowerShell, by the command line library: commands, options, and names of what
ships.
"""

from __future__ import annotations

import os
from collections.abc import Callable

import typer
import typer.main

from gimbal_hil.surface.cli.commands import COMMANDS, function_of
from gimbal_hil.surface.cli.help_text import help_text

#: typer asks which shell this is, unless a shell is named; then it wants to be told so
_SHELL_IS_NAMED = "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION"


def complete(words: list[str]) -> int:
    """Answer `--install-completion [SHELL]`, `--show-completion [SHELL]`, or the shell that wants to know how a line
    may go on.
    """
    if len(words) > 1 and words[0].endswith("-completion"):
        os.environ[_SHELL_IS_NAMED] = "1"
    code = whole_app()(words, prog_name="gimbal-hil", standalone_mode=False)
    return code if isinstance(code, int) else 0


def whole_app() -> typer.Typer:
    """All commands as one application; each command's own module is loaded."""
    app = typer.Typer(name="gimbal-hil", add_completion=True, rich_markup_mode=None)
    for name, one in COMMANDS.items():
        app.command(name=name, short_help=one.line)(function_of(name)[1])
    return app


def help_of(name: str) -> str:
    """What `--help` of a command says."""
    command = typer.main.get_command(whole_app()).commands[name]  # type: ignore[attr-defined]
    return help_text(command, name)


def model_names(incomplete: str) -> list[str]:
    """Names of shipped models that begin so; empty where a file is meant."""
    from sim_backend.shipped import shipped_file

    return sorted(path.stem for path in shipped_file("models").glob(f"{_literal(incomplete)}*.yaml"))


def one_of(*names: str) -> Callable[[str], list[str]]:
    """A completer that knows these names."""
    return lambda incomplete: [name for name in names if name.startswith(incomplete)]


def _literal(text: str) -> str:
    import glob

    return glob.escape(text)
