"""Plans as data: what a file may hold, what it becomes, and what is refused in which words."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from firmware_protocol.errors import BadInputError
from gimbal_hil.knowledge.experiments.plan import Plan, load_plan, plan_from_document
from gimbal_hil.loop.host import AxisCommand, EndCondition, EndKind, HostState, Mode, ReferenceOrigin, Shape
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.realtime.lockstep import CompiledPath
from sim_backend.model import shipped_model

DOCUMENT: dict[str, Any] = {
    "schema": 1,
    "name": "two speeds",
    "laps": 2,
    "segments": [
        {
            "name": "go",
            "outer": {"mode": "position", "shape": "smooth", "target_rad": 0.1, "over_s": 0.4},
            "inner": {"mode": "position"},
            "duration_s": 0.5,
        },
        {
            "outer": {"mode": "rate", "value_rad_s": 0.2},
            "inner": {"mode": "position", "from_start": True},
            "duration_s": 3.0,
            "end": [{"axis": "outer", "position_above_rad": 0.3, "for_s": 0.01}],
            "guards": {"outer": {"rate_rad_s": 1.0}},
            "record_every_ticks": 5,
            "measure": True,
        },
    ],
}


def test_a_plan_becomes_segments_of_the_host() -> None:
    go, slow, again, last = plan_from_document(DOCUMENT, "plan").host_segments(1000.0)
    assert go.outer.mode is Mode.POSITION and go.outer.shape is Shape.SMOOTH and go.outer.parameters == (0.1, 0.4)
    assert go.inner.mode is Mode.POSITION and go.inner.parameters == (0.0,)
    assert slow.duration_ticks == 3000 and slow.record_every == 5
    assert slow.ends == (EndCondition(EndKind.POSITION_ABOVE, 0, 0.3, 10),)
    assert slow.inner.origin is ReferenceOrigin.START and slow.outer.guard.rate_rad_s == 1.0
    assert [one.label for one in (go, slow, again, last)] == [0, 1, 2, 3]
    assert last.switch_off_afterwards and not again.switch_off_afterwards


def test_a_plan_runs_to_its_end_in_lockstep() -> None:
    path = CompiledPath(shipped_settings(), shipped_model(), 1)
    path.connect()
    recorded = path.run(plan_from_document(DOCUMENT, "plan").program(1000.0))
    assert [event.text for event in recorded.events if "ended" in event.text] == [
        "segment 0 ended (duration)",
        "segment 1 ended (end_condition)",
        "segment 2 ended (duration)",
        "segment 3 ended (end_condition)",
    ]
    path.advance(1000)
    assert path.host.state is HostState.IDLE


def test_a_plan_is_the_same_after_it_was_written_and_read(tmp_path: Path) -> None:
    path = tmp_path / "plan.yaml"
    path.write_text(yaml.safe_dump(DOCUMENT))
    plan = load_plan(path)
    again = Plan.model_validate(plan.model_dump(mode="json", by_alias=True))
    assert again.program(1000.0).values.tobytes() == plan.program(1000.0).values.tobytes()


def test_a_multisine_keeps_its_peak_and_its_lines() -> None:
    axis = {
        "mode": "rate",
        "shape": "multisine",
        "amplitude_rad_s": 0.3,
        "first_hz": 0.5,
        "last_hz": 20.0,
        "lines": 12,
        "period_s": 4.0,
        "periods": 2,
    }
    plan = plan_from_document({"schema": 1, "name": "m", "segments": [{"outer": axis, "duration_s": 8.0}]}, "plan")
    command: AxisCommand = plan.host_segments(1000.0)[0].outer
    wave = np.asarray(command.table)
    assert command.shape is Shape.TABLE and len(wave) == 8001
    assert np.abs(wave).max() == pytest.approx(0.3)
    spectrum = np.abs(np.fft.rfft(wave[:4000])) / 2000
    assert np.count_nonzero(spectrum > 1e-6) == 12


Change = Callable[[list[dict[str, Any]]], object]


@pytest.mark.parametrize(
    ("change", "key", "says"),
    [
        (lambda s: s[1]["outer"].update(value_rad=1.0), "segments.1.outer", "expected value_rad_s"),
        (lambda s: s[0]["outer"].update(targt_rad=1.0), "targt_rad", "unknown key"),
        (lambda s: s[0]["outer"].update(mode="fast"), "segments.0.outer", "no mode 'fast'"),
        (lambda s: s[0]["outer"].pop("over_s"), "over_s", "is missing"),
        (lambda s: s[1]["end"][0].update(rate_above_rad_s=1.0), "segments.1.end.0", "exactly one of"),
        (lambda s: s[0].update(duration_s=-1.0), "segments.0.duration_s", "greater than 0"),
        (lambda s: s[0].pop("duration_s"), "segments.0.duration_s", "is missing"),
        (lambda s: s.clear(), "segments", "at least 1"),
    ],
)
def test_a_bad_plan_is_refused_with_its_key(change: Change, key: str, says: str) -> None:
    document = copy.deepcopy(DOCUMENT)
    change(document["segments"])
    with pytest.raises(BadInputError) as refused:
        plan_from_document(document, "plan.yaml")
    assert key in refused.value.where and refused.value.where.startswith("plan.yaml: ")
    assert says in str(refused.value)


def test_a_missing_or_broken_plan_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInputError, match="no such file"):
        load_plan(tmp_path / "none.yaml")
    (tmp_path / "broken.yaml").write_text("a: [1,\nb: 2")
    with pytest.raises(BadInputError, match="is not YAML at line"):
        load_plan(tmp_path / "broken.yaml")
