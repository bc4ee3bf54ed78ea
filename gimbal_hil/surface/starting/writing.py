"""Writes a described antenna into a folder, checked by the loaders before the first file is there."""

from __future__ import annotations

from pathlib import Path

from firmware_protocol.documents import yaml_text
from firmware_protocol.errors import BadInputError
from firmware_protocol.places import require_new
from gimbal_hil.knowledge.experiments import plan_from_document
from gimbal_hil.loop.settings import settings_from_document
from gimbal_hil.surface.checking import SCHEMA_LINE, FileKind, schema_text
from gimbal_hil.surface.starting.description import AntennaDescription
from gimbal_hil.surface.starting.documents import configuration_document, link_document, model_document, plan_document
from gimbal_hil.surface.starting.readme import readme_text
from sim_backend.model import ModelKind, model_from_document

MODEL, CONFIGURATION, REHEARSAL, PLAN, README = (
    "model.yaml",
    "antenna.yaml",
    "rehearsal.yaml",
    "plan.yaml",
    "README.md",
)
SCHEMAS = ".schemas"


def write_antenna(antenna: AntennaDescription, folder: Path, force: bool) -> list[Path]:
    """Write model, configuration, plan, schemas and README; the paths written, README last.

    Raises:
        BadInputError: a described number is impossible, or a file is there already and not to be overwritten.
    """
    documents = {MODEL: (FileKind.MODEL, model_document(antenna))}
    if antenna.kind is ModelKind.GIMBAL:
        link = link_document(antenna)
        documents[CONFIGURATION] = (FileKind.CONFIGURATION, configuration_document(antenna, MODEL, link))
        if link is not None:
            documents[REHEARSAL] = (FileKind.CONFIGURATION, configuration_document(antenna, MODEL, None))
        documents[PLAN] = (FileKind.PLAN, plan_document(antenna))
    names = tuple(axis.name for axis in antenna.axes)
    for name, (kind, document) in documents.items():
        if kind is FileKind.MODEL:
            model_from_document(document, name)
        elif kind is FileKind.CONFIGURATION:
            settings_from_document(document, name)
        else:
            plan_from_document(document, name, names)
    texts = {
        name: SCHEMA_LINE.format(path=f"{SCHEMAS}/{kind.value}.json") + yaml_text(document, leaves_in_line=True)
        for name, (kind, document) in documents.items()
    }
    texts |= {f"{SCHEMAS}/{kind.value}.json": schema_text(kind) for kind, _ in documents.values()}
    texts[README] = readme_text(antenna, folder)
    require_new(folder, force, *texts)
    try:
        (folder / SCHEMAS).mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise BadInputError(str(folder), f"cannot be written ({error.strerror})", "a folder that can") from None
    return [folder / name for name in texts]
