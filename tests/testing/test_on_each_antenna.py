"""A user's file of ten lines, and the project's own tests of a link, unchanged on every antenna that there is without
one on the bench.
"""

from __future__ import annotations

import importlib.util
import shutil
from pathlib import Path

import pytest

from tests.conformance.test_over_links import plant
from tests.testing.test_plugin import ROOT, USERS_FILE, users_pytest

pytestmark = pytest.mark.realtime
OWN_FILE = (ROOT / "tests" / "real_link" / "test_antenna.py").read_text()
_COMPILER = shutil.which("cc") or shutil.which("gcc")
_MISSING = [tool for tool in ("arm-none-eabi-gcc", "qemu-system-arm") if shutil.which(tool) is None]
needs_compiler = pytest.mark.skipif(_COMPILER is None, reason="needs a C compiler (apt install gcc)")
needs_arm = pytest.mark.skipif(
    "arm-none-eabi-gcc" in _MISSING or importlib.util.find_spec("unicorn") is None,
    reason="needs apt's gcc-arm-none-eabi and unicorn (pip install unicorn)",
)
needs_board = pytest.mark.skipif(
    bool(_MISSING), reason=f"needs apt's qemu-system-arm and gcc-arm-none-eabi: no {_MISSING}"
)


def good(folder: Path, *options: str) -> None:
    """The user's file is one test, the project's four; all of them are good."""
    mine = folder / "mine"
    mine.mkdir()
    (mine / "test_own.py").write_text(OWN_FILE)
    done = users_pytest(mine, USERS_FILE, *options)
    assert done.returncode == 0 and "5 passed" in done.stdout, done.stdout


@pytest.mark.parametrize(
    "firmware",
    [
        pytest.param("virtual", marks=pytest.mark.heavy),
        pytest.param("c", marks=needs_compiler),
        pytest.param("cortex-m", marks=[needs_arm, pytest.mark.heavy]),
        pytest.param("qemu", marks=[needs_board, pytest.mark.heavy]),
    ],
)
def test_the_same_files_are_good_in_this_process(firmware: str, tmp_path: Path) -> None:
    good(tmp_path, "--gimbal-link", firmware)


@pytest.mark.heavy
def test_they_are_good_on_an_antenna_that_waits_behind_a_pseudo_terminal(tmp_path: Path) -> None:
    with plant("serial", tmp_path / "ready", "--lockstep") as path:
        good(tmp_path, "--gimbal-link", f"serial:{path}", "--gimbal-lockstep")


@pytest.mark.heavy
def test_they_are_good_in_real_time_over_a_pseudo_terminal(tmp_path: Path) -> None:
    with plant("serial", tmp_path / "ready") as path:
        good(tmp_path, "--gimbal-link", f"serial:{path}")


@pytest.mark.heavy
@needs_board
def test_they_are_good_over_the_uart_of_a_board(tmp_path: Path) -> None:
    """A pseudo-terminal whose other end is the UART of QEMU's board, in another process."""
    shipped = (ROOT / "config" / "virtual_antenna.yaml").read_text()
    configuration = tmp_path / "board.yaml"
    configuration.write_text(shipped.replace("{model: thesis, seed: 1}", "{model: thesis, seed: 1, firmware: qemu}"))
    assert "qemu" in configuration.read_text()
    with plant("serial", tmp_path / "ready", "--lockstep", "--config", str(configuration)) as path:
        good(tmp_path, "--gimbal-link", f"serial:{path}", "--gimbal-lockstep")
