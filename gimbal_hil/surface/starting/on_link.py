"""A configuration with another link than its own, as a person writes it after `--link`."""

from __future__ import annotations

from pathlib import Path

from gimbal_hil.loop.settings import (
    DaemonSettings,
    EmbeddedAntenna,
    load_settings,
    settings_from_document,
    shipped_settings,
)
from gimbal_hil.surface.starting.description import parse_link
from sim_backend.firmware_run import FirmwareRun


def settings_on_link(config: Path | None, link: str | None, where: str = "--link") -> DaemonSettings:
    """The configuration (the shipped one without `config`) on this link (its own without `link`): the name of a
    firmware stands for the embedded antenna with it. BadInputError where there is no such link.
    """
    settings = load_settings(config) if config else shipped_settings()
    if link is None:
        return settings
    firmware = next((run for run in FirmwareRun if run.value == link), None)
    if firmware is not None:
        own = settings.link if isinstance(settings.link, EmbeddedAntenna) else EmbeddedAntenna()
        embedded = own.embedded.model_copy(update={"firmware": firmware})
        return settings.model_copy(update={"link": own.model_copy(update={"embedded": embedded})})
    document = settings.model_dump(mode="json", by_alias=True)
    return settings_from_document(document | {"link": parse_link(link).section}, where)
