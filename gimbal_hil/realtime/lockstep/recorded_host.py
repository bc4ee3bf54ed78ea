"""The host core that a run was made with, set up again from what the run folder says."""

from __future__ import annotations

from collections.abc import Callable

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.runs import BEGINS, Event, RecordedRun
from gimbal_hil.loop.host import Host, Program, stand_as
from gimbal_hil.loop.settings import (
    DaemonSettings,
    adjusted,
    adjustments_from,
    host_configuration,
    settings_from_document,
)


def host_of(run: RecordedRun, other: DaemonSettings | None = None) -> Host:
    """A host with the run's configuration, or an `other` one for the same antenna; raises BadInputError where the run
    keeps too little to be run again, or where the other configuration has another rate or other axes.
    """
    settings = _settings_of(run)
    if not settings.recording.frames or settings.recording.every_ticks != 1:
        raise BadInputError(
            f"{run.folder / 'run.yaml'}: configuration.recording",
            "this run does not keep every frame and tick",
            "frames: true and every_ticks: 1",
        )
    return Host(host_configuration(settings if other is None else _fitting(run, other)), run.record.header.axes)


def _fitting(run: RecordedRun, other: DaemonSettings) -> DaemonSettings:
    """The other configuration as a run of this antenna would have it."""
    header = run.record.header
    if round(1e9 / other.rate_hz) != header.period_ns:
        recorded = f"{1e9 / header.period_ns:g} Hz, as recorded in {run.folder}"
        raise BadInputError("--config: rate_hz", f"is {other.rate_hz:g} Hz", recorded)
    return other.for_axes(header.axes, str(run.folder)).with_model()


def _settings_of(run: RecordedRun) -> DaemonSettings:
    where = f"{run.folder / 'run.yaml'}: configuration"
    return settings_from_document(dict(run.record.header.configuration), where)


def give_again(host: Host, run: RecordedRun, event: Event, other: DaemonSettings | None = None) -> None:
    """Ask of the host what a COMMAND event says was asked; raises BadInputError for an event that is no command. Gains
    that an operator changed stay those of an `other` configuration, which is in their place.
    """
    where = f"{run.folder / 'events.jsonl'}: command at tick {event.tick}"
    command, program = event.data.get("command"), event.data.get("program")
    plain: dict[object, Callable[[], None]] = {
        "stop": host.stop,
        "quick_stop": host.quick_stop,
        "fault_reset": host.reset_fault,
    }
    plain |= {"distrust": host.distrust}
    if command == "image":
        # in the middle of a run the host stands there by itself
        if event.data.get(BEGINS) is True:
            stand_as(host, event.data.get("image"), event.data.get("words"), where)
            if other is not None:
                host.adjust(host_configuration(_fitting(run, other)))
    elif command == "start" and isinstance(program, dict):
        host.command(Program.from_document(program, where))
    elif command == "adjust":
        values = adjustments_from(event.data.get("values"), where)
        if other is None:
            host.adjust(host_configuration(adjusted(_settings_of(run), values, where)))
    elif command in plain:
        plain[command]()
    else:
        raise BadInputError(
            where,
            f"is {command!r}",
            "start with its program, adjust with its values, or one of " + ", ".join(map(str, plain)),
        )
