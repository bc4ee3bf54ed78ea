"""Where the antenna is: embedded in this process, or behind a link."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Discriminator, Field, Tag

from firmware_protocol.documents import Strict
from firmware_protocol.links import AdapterLinkConfig, CanLinkConfig, SerialLinkConfig, UnixLinkConfig
from sim_backend.firmware_run import FirmwareRun


def is_model_file(name: str) -> bool:
    """Whether a model is named by its path and not by a shipped name."""
    return name.endswith((".yaml", ".yml")) or "/" in name


class Embedded(Strict):
    """The virtual antenna in this process: name of a shipped model or path of a model file (relative to this file),
    seed of its noise, its firmware.
    """

    model: str = Field(
        default="thesis", description="name of a shipped model, or path of a model file (relative to this file)"
    )
    seed: Annotated[int, Field(ge=0, lt=2**31)] = Field(default=1, description="seed of its noise")
    firmware: FirmwareRun = Field(
        default=FirmwareRun.VIRTUAL,
        description="whose firmware answers: the virtual antenna's own, or the C device as a library (c), as machine "
        "code (cortex-m) or as a board's image in an emulator (qemu)",
    )


class EmbeddedAntenna(Strict):
    """`link: {embedded: {model: ..., seed: ...}}`."""

    embedded: Embedded = Field(default=Embedded(), description="which model, and which noise")


def _kind(link: object) -> str | None:
    if isinstance(link, EmbeddedAntenna) or (isinstance(link, dict) and "embedded" in link):
        return "embedded"
    kind = link.get("kind") if isinstance(link, dict) else getattr(link, "kind", None)
    return kind if isinstance(kind, str) else None


LinkSettings = Annotated[
    Annotated[EmbeddedAntenna, Tag("embedded")]
    | Annotated[CanLinkConfig, Tag("can")]
    | Annotated[SerialLinkConfig, Tag("serial")]
    | Annotated[UnixLinkConfig, Tag("unix")]
    | Annotated[AdapterLinkConfig, Tag("adapter")],
    Discriminator(
        _kind,
        custom_error_type="link_kind",
        custom_error_message="names no link that there is: embedded: {model, seed}, or kind: can, serial, unix, "
        "adapter",
    ),
]
#: names of the kinds, which stand in the path of an error but not in the file
LINK_KINDS: dict[str, type[BaseModel]] = {
    "embedded": EmbeddedAntenna,
    "can": CanLinkConfig,
    "serial": SerialLinkConfig,
    "unix": UnixLinkConfig,
    "adapter": AdapterLinkConfig,
}
