"""What is compiled is said in whichever command asks first, what is on disk already is not, and `warm` knows every
kernel.
"""

from __future__ import annotations

import io
import json
import sys
from pathlib import Path

import numba
import pytest

from firmware_protocol.compiling import compiled
from gimbal_hil.surface.cli import main
from gimbal_hil.surface.cli.compiling import _KERNELS, compiling_shown
from gimbal_hil.surface.warming import KERNELS, Kernel

ROOT = Path(__file__).resolve().parent.parent.parent


class Terminal(io.StringIO):
    """Stands for a person's terminal."""

    def isatty(self) -> bool:
        return True


def run_ticks(n: int) -> int:
    """Bears the name of a kernel of this project, and costs next to nothing."""
    return n + 1


def test_a_kernel_that_is_compiled_is_announced_with_its_place_and_its_time(capsys: pytest.CaptureFixture[str]) -> None:
    with compiling_shown():
        assert numba.njit(run_ticks)(1) == 2
    said = capsys.readouterr().err
    assert "compiling host and antenna in one loop for this machine (once; kept in " in said
    assert "compiled in " in said


def test_in_a_terminal_a_bar_shows_it(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    with compiling_shown():
        numba.njit(run_ticks)(1)
    assert "compiling host and antenna in one loop (once on this machine)" in terminal.getvalue()
    assert " %" in terminal.getvalue()


def test_what_is_compiled_already_and_other_peoples_functions_are_not_announced(
    capsys: pytest.CaptureFixture[str],
) -> None:
    ready = numba.njit(run_ticks)
    ready(1)
    with compiling_shown():
        ready(2)
        numba.njit(lambda n: n + 1)(1)
    assert capsys.readouterr().err == ""


def entry_points() -> set[str]:
    """Names of the functions below `@entry_point` or `@assembled_entry_point`, of all rooms."""
    found = set()
    for room in ("sim_backend", "gimbal_hil"):
        for path in (ROOT / room).rglob("*.py"):
            lines = path.read_text().splitlines()
            found |= {
                lines[at + 1].removeprefix("def ").split("(")[0]
                for at, line in enumerate(lines)
                if line == "@entry_point" or line.startswith("@assembled_entry_point(")
            }
    return found


def test_every_kernel_that_a_command_calls_has_a_name_for_people() -> None:
    # the one that only tests call
    assert entry_points() - {"joint_accelerations"} == set(_KERNELS)


def test_warm_asks_for_every_kernel_and_says_how_long_each_took(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = []
    for kernel in KERNELS:
        monkeypatch.setitem(kernel.__dict__, "ask", lambda name=kernel.name: asked.append(name))
    for words in (["warm"], ["warm", "--json"]):
        with pytest.raises(SystemExit) as end:
            main(words)
        assert end.value.code == 0
        assert sorted(asked) == sorted(kernel.name for kernel in KERNELS)
        asked.clear()
    said = capsys.readouterr().out
    assert all(kernel.text in said for kernel in KERNELS)
    assert "next: gimbal-hil demo" in said
    assert set(json.loads(said.splitlines()[-1])["seconds"]) == {kernel.text for kernel in KERNELS}


def test_an_inner_function_answers_python_too_and_is_wrapped_for_it_only_then() -> None:
    @compiled
    def half(x: float) -> float:
        return 0.5 * x

    @numba.njit  # type: ignore[untyped-decorator]
    def quarter(x: float) -> float:
        return half(half(x))

    assert quarter(1.0) == 0.25
    assert "from_python" not in half.__dict__
    assert half(1.0) == 0.5
    assert "from_python" in half.__dict__


@pytest.mark.parametrize(
    "kernel", [k for k in KERNELS if "thesis" in k.text or "one axis" in k.text], ids=lambda k: k.text
)
def test_what_warm_calls_for_the_small_kernels_works(kernel: Kernel) -> None:
    kernel.ask()


@pytest.mark.heavy
def test_after_warm_no_kernel_of_a_step_and_a_fit_is_compiled(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for kernel in KERNELS:
        kernel.ask()
    capsys.readouterr()
    with pytest.raises(SystemExit) as end:
        main(["experiment", "step", "--short", "--out", str(tmp_path / "step")])
    assert end.value.code == 0
    with pytest.raises(SystemExit):
        main(["daemon", "--lockstep", "--duration", "0.5", "--out", str(tmp_path / "daemon")])
    assert "compiling" not in capsys.readouterr().err
