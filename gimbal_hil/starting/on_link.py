"""A configuration with another link than its own, as a person writes it after `--link`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gimbal_hil.settings import (
    DaemonSettings,
    EmbeddedAntenna,
    load_settings,
    settings_from_document,
    shipped_settings,
)
from gimbal_hil.starting.description import parse_link

if TYPE_CHECKING:
    from sim_backend.firmware import FirmwareRun


def settings_on_link(
    config: Path | None, link: str | None, where: str = "--link"
) -> tuple[DaemonSettings, FirmwareRun | None]:
    """The configuration (the shipped one without `config`) on this link (its own without `link`), and how the C device
    is run where the link is `c` or `cortex-m`: the embedded antenna with it. BadInputError where there is no such link.
    """
    settings = load_settings(config) if config else shipped_settings()
    if link is None:
        return settings, None
    firmware = None
    if ":" not in link and link != "virtual":
        # numba comes with it
        from sim_backend.firmware import FirmwareRun

        firmware = next((run for run in FirmwareRun if run.value == link), None)
    if firmware is not None or link == "virtual":
        own = settings.link if isinstance(settings.link, EmbeddedAntenna) else EmbeddedAntenna()
        return settings.model_copy(update={"link": own}), firmware
    document = settings.model_dump(mode="json", by_alias=True)
    return settings_from_document(document | {"link": parse_link(link).section}, where), None
