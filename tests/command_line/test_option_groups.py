"""A parameter whose type is a dataclass of options stands for its fields."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import pytest
import typer
from typer.testing import CliRunner

from gimbal_hil.data.signals import LogReading
from gimbal_hil.surface.cli.commands import COMMANDS, function_of
from gimbal_hil.surface.cli.log_options import LogOptions
from gimbal_hil.surface.cli.option_groups import with_groups


@dataclass(frozen=True)
class Lens:
    """Options of a lens."""

    width: Annotated[float, typer.Option(help="Width, mm.")]
    colour: Annotated[list[str] | None, typer.Option(help="May be repeated.")] = None


def look(*, name: Annotated[str, typer.Argument()], lens: Lens, quiet: bool = False) -> int:
    """Look through a lens."""
    print(name, lens, quiet)
    return 0


def said(*words: str) -> tuple[int, str]:
    app = typer.Typer(add_completion=False)
    app.command()(with_groups(look))
    result = CliRunner().invoke(app, list(words))
    return result.exit_code, result.output


def test_fields_are_options_and_arrive_as_one_frozen_value() -> None:
    code, text = said("sky", "--width", "2.5", "--colour", "red", "--colour", "blue", "--quiet")
    assert code == 0 and text == "sky Lens(width=2.5, colour=['red', 'blue']) True\n"
    assert said("sky", "--width", "2")[1] == "sky Lens(width=2.0, colour=None) False\n"


def test_a_field_without_a_default_is_required_and_help_has_all_fields() -> None:
    code, text = said("sky")
    assert code == 2 and "--width" in text
    assert all(word in said("--help")[1] for word in ("--width", "--colour", "--quiet", "Width, mm."))


def test_a_command_without_groups_is_left_as_it_is() -> None:
    def plain(name: str) -> int:
        return len(name)

    assert with_groups(plain) is plain


@pytest.mark.parametrize("name", COMMANDS)
def test_no_command_takes_a_group_as_an_option(name: str) -> None:
    import inspect
    from dataclasses import is_dataclass

    parameters = inspect.signature(function_of(name)[1], eval_str=True).parameters
    assert not any(is_dataclass(one.annotation) for one in parameters.values())


def test_logs_are_read_as_the_options_say() -> None:
    reading = LogOptions(column=["joint.position=theta:deg"], rate=200.0, repair=True).reading()
    assert reading.columns.states_time_of("joint") is False
    assert reading == LogReading(reading.columns, resample=False, rate_hz=200.0, drop_invalid=False, repair=True)
