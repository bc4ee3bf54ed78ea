"""The pytest plugin: `pytest --gimbal-link LINK`, and the fixtures `antenna` and `recorded_run`.

Loaded by every pytest where this package is installed, so what is heavy is loaded by the fixtures.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from gimbal_hil.surface.testing.antennas import AntennaOfTest
    from gimbal_hil.surface.testing.recorded import RecordedSignals

_FIXTURE = "antenna"


def pytest_addoption(parser: pytest.Parser) -> None:
    """The options; nothing changes for tests that do not use the fixtures."""
    group = parser.getgroup("gimbal", "a gimballed antenna (gimbal-hil)")
    group.addoption(
        "--gimbal-link", metavar="LINK", help="virtual (default), c, cortex-m, qemu, unix:PATH, serial:PORT, ..."
    )
    group.addoption("--gimbal-lockstep", action="store_true", help="the antenna on the link waits, as plant --lockstep")
    group.addoption("--gimbal-config", metavar="FILE", help="configuration file; its link unless --gimbal-link")
    group.addoption("--gimbal-out", metavar="DIR", help="keep the run folder of each test below this folder")
    group.addoption("--gimbal-run", metavar="RUN", help="run folder that the fixture recorded_run opens")


@pytest.fixture
def antenna(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[AntennaOfTest]:
    """An antenna that is connected and ready to be moved; what happens is recorded, and made safe at the end."""
    from firmware_protocol.errors import GimbalHilError
    from gimbal_hil.surface.starting import settings_on_link
    from gimbal_hil.surface.testing.antennas import antenna_of

    try:
        file, link = request.config.getoption("--gimbal-config"), request.config.getoption("--gimbal-link")
        settings = settings_on_link(Path(file) if file else None, link, "--gimbal-link")
        opened = antenna_of(
            settings, _folder(request, tmp_path), lockstep=request.config.getoption("--gimbal-lockstep")
        )
    except GimbalHilError as error:
        pytest.fail(f"no antenna: {error}", pytrace=False)
    request.node.user_properties.append(("gimbal_run", str(opened.folder)))
    try:
        yield opened
    finally:
        opened.close()


@pytest.fixture
def recorded_run(request: pytest.FixtureRequest) -> RecordedSignals:
    """The run folder of --gimbal-run; a test that uses it is skipped without."""
    from gimbal_hil.surface.testing.recorded import RecordedSignals

    folder = request.config.getoption("--gimbal-run")
    if folder is None:
        pytest.skip("needs --gimbal-run RUN")
    return RecordedSignals(Path(folder))


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Iterator[None]:
    """The log of steps and the place of the recording, beside whatever a failed test says."""
    outcome: Any = yield
    opened: Any = getattr(item, "funcargs", {}).get(_FIXTURE)
    if call.when == "call" and hasattr(opened, "steps"):
        lines = [*opened.steps, f"recorded in {opened.folder}"]
        outcome.get_result().sections.append(("antenna", "\n".join(lines)))


def _folder(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    out = request.config.getoption("--gimbal-out")
    if out is None:
        return tmp_path / "run"
    name = "".join(letter if letter.isalnum() or letter in "-_" else "-" for letter in request.node.name)
    return Path(out) / name
