"""Every reader of documents, from bytes to what the machine would work with."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

from firmware_protocol.documents import json_line, yaml_mapping
from gimbal_hil.knowledge.experiments.plan import plan_from_document
from gimbal_hil.loop.settings import EmbeddedAntenna, host_configuration, settings_from_document
from gimbal_hil.realtime.service.operator_commands import PlainRequest, parse_request
from sim_backend.model import model_from_document, plant_arrays

CONFIG = Path(__file__).resolve().parents[2] / "config"
Reader = Callable[[bytes], object]


def read_configuration(data: bytes) -> object:
    """A daemon's configuration, as far as the host's numbers."""
    settings = settings_from_document(yaml_mapping(data, "file", "a configuration"), "file", Path("/nowhere"))
    # a model's file is another document
    assert isinstance(settings.link, EmbeddedAntenna) or settings.link.kind
    return host_configuration(settings)


def read_plan(data: bytes) -> object:
    """A plan, as far as the host's program at 1 kHz; long ones are looked at, not built."""
    plan = plan_from_document(yaml_mapping(data, "file", "a plan"), "file")
    return plan.program(1000.0) if plan.laps * len(plan.segments) <= 2000 else plan.longest_s


def read_model(data: bytes) -> object:
    """A model file, as far as the plant's arrays."""
    return plant_arrays(model_from_document(yaml_mapping(data, "file", "a model"), "file"))


def read_request(data: bytes) -> object:
    """A line at the operator's door, as far as the program that the host would be given."""
    request = parse_request(json_line(data, "line", "a request"))
    return request if isinstance(request, PlainRequest) else request.program(0.001)


EVERY_SHAPE = """
schema: 1
name: every shape
laps: 2
segments:
  - {outer: {mode: position, shape: hold, value_rad: 0.1}, inner: {mode: torque, value_nm: 0.1}, duration_s: 0.1}
  - {outer: {mode: rate, shape: ramp, slope_rad_s2: 0.1, span_rad_s: 0.2}, duration_s: 0.1, record_every_ticks: 2}
  - {outer: {mode: rate, shape: sine, amplitude_rad_s: 0.1, frequency_hz: 2.0, phase_rad: 0.1}, duration_s: 0.1}
  - {inner: {mode: torque, shape: chirp, amplitude_nm: 0.1, first_hz: 1.0, last_hz: 9.0, sweep_s: 2.0}, duration_s: 2.0}
  - outer: {mode: position, shape: trapezoid, target_rad: 1.0, largest_slope_rad_s: 0.2, largest_curvature_rad_s2: 1.0}
    duration_s: 2.0
  - inner: {mode: torque, shape: pulses, amplitude_nm: 0.1, period_s: 0.5, width_s: 0.1, alternating: true, count: 3}
    duration_s: 2.0
  - {outer: {mode: inertial_rate, shape: table, values_rad_s: [0.0, 0.1, 0.0], row_s: 0.1, scale: 2.0}, duration_s: 0.3}
  - outer: {mode: rate, shape: multisine, amplitude_rad_s: 0.3, first_hz: 0.5, last_hz: 9.0, lines: 4,
            period_s: 2.0, periods: 2}
    duration_s: 4.0
    end: [{axis: outer, position_above_rad: 0.3, for_s: 0.01}]
    guards: {outer: {rate_rad_s: 1.0, low_rad: -1.0, high_rad: 1.0, torque_nm: 3.0}}
    meaning: {speed: 0.1, kind: slow}
"""

_BEFORE_LINK, _, _AFTER_LINK = (CONFIG / "virtual_antenna.yaml").read_text().partition("\nlink:\n")
EVERY_LINK = (
    _BEFORE_LINK
    + """
link:
  kind: can
  interface: virtual
  channel: a
  bitrate: 1000000
  options: {fd: false}
  faults:
    seed: 1
    send: {drop: 0.1, corrupt: 0.1, corrupt_bits: 2}
    receive: {delay: 0.1, delay_ticks: 2}
    cuts: [{start_tick: 5, ticks: 3}]
"""
    + _AFTER_LINK.partition("\n")[2]
)


def shipped(kind: str) -> list[str]:
    """Texts of the shipped files of a kind."""
    names = {"configuration": "*.yaml", "model": "models/*.yaml", "plan": "plans/*.yaml"}
    texts = [path.read_text() for path in sorted(CONFIG.glob(names[kind]))]
    return texts + [EVERY_SHAPE] if kind == "plan" else texts + [EVERY_LINK] if kind == "configuration" else texts


REQUESTS: tuple[dict[str, Any], ...] = (
    {"id": 1, "command": "set_point", "mode": "position", "outer": 0.5, "inner": -0.3, "over_s": 2.0},
    {"id": 2, "command": "mode", "outer": "rate", "inner": "position"},
    {
        "id": 3,
        "command": "segments",
        "segments": [
            {
                "outer": {"mode": "rate", "shape": "table", "parameters": [0.01, 1.0], "table": [0.0, 0.1, 0.2]},
                "duration_s": 1.0,
            },
            {
                "inner": {"mode": "position", "shape": "sine", "parameters": [0.0, 0.1, 1.0, 0.0]},
                "label": 1,
                "switch_off_afterwards": True,
            },
        ],
    },
    {"id": 4, "command": "quick_stop"},
)

READERS: dict[str, Reader] = {
    "configuration": read_configuration,
    "plan": read_plan,
    "model": read_model,
    "request": read_request,
}


def start_request(random: Random) -> dict[str, Any]:
    """A program as experiments hand it in."""
    from gimbal_hil.loop.host import AxisCommand, Mode, Segment, Shape, program_of

    shape = random.choice([(Shape.HOLD, (0.1,)), (Shape.SMOOTH, (0.1, 1.0)), (Shape.CHIRP, (0.0, 0.1, 1.0, 0.1, 5.0))])
    program = program_of([Segment(AxisCommand(Mode.POSITION, *shape), AxisCommand(), 1000, label=3)])
    return {"id": 9, "command": "start", "program": program.as_document()}
