"""The page on guards says what the code has: every cause and fault, the reaction in force, a test that exists."""

from __future__ import annotations

from pathlib import Path

from firmware_protocol.enumerations import FaultCode
from gimbal_hil.loop.host import GUARD_CAUSES
from gimbal_hil.loop.host.guard_page import guard_page
from gimbal_hil.loop.host.guard_table import DRIVE_GUARDS, HOST_GUARDS, NOT_IN_THE_VIRTUAL_ANTENNA
from tests.device.guard_scenarios import SCENARIOS

ROOT = Path(__file__).resolve().parents[2]


def test_every_cause_and_every_fault_has_its_row() -> None:
    assert {guard.cause for guard in HOST_GUARDS} == set(GUARD_CAUSES)
    assert {guard.fault for guard in DRIVE_GUARDS} | NOT_IN_THE_VIRTUAL_ANTENNA | {FaultCode.NONE} == set(FaultCode)


def test_the_tests_that_the_table_names_are_there() -> None:
    for guard in HOST_GUARDS:
        text = (ROOT / guard.test).read_text()
        assert f"HostCause.{guard.cause.name}" in text or f"({guard.cause.name.lower()})" in text, guard.cause
    assert {guard.test for guard in DRIVE_GUARDS} <= set(SCENARIOS)


def test_the_kept_page_is_what_the_table_gives() -> None:
    assert (ROOT / "docs" / "reference" / "guards.md").read_text() == guard_page()
