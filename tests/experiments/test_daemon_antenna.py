"""A sequence through the daemon and an antenna in another process, in real time, over a pseudo-terminal."""

from __future__ import annotations

import signal
import time
from pathlib import Path

import numpy as np
import pytest

from firmware_protocol.errors import BadInputError, LinkError, SafetyStopError
from gimbal_hil.data.runs import damage_of
from gimbal_hil.knowledge.experiments.conducting import conduct, conduct_through_daemon
from gimbal_hil.knowledge.experiments.daemon_antenna import DaemonAntenna
from gimbal_hil.knowledge.experiments.experiment import Experiment
from gimbal_hil.knowledge.experiments.runner import Outcome
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.surface.library import Run
from sim_backend.model import shipped_model
from tests.daemon.daemons import RunningDaemon
from tests.daemon.test_two_processes import RunningPlant, configuration
from tests.experiments.small_sequence import small_sequence

pytestmark = pytest.mark.realtime

#: a machine that stalls for longer than the antenna's deadman ends a try, as it should; then it is made again
TRIES = 40


def test_a_folder_without_a_daemon_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInputError):
        DaemonAntenna(tmp_path, ())


def conducted_in_spite_of_stalls(experiment: Experiment, daemon: RunningDaemon, out: Path) -> Outcome:
    problems = []
    for number in range(TRIES):
        with daemon.client() as client:
            while daemon.until_state(client, "idle", "fault", "active")["host_state"] == "fault":
                client.request("fault_reset")
                time.sleep(0.5)
        try:
            return conduct_through_daemon(
                experiment, daemon.run, out, force=True, resume=bool(number) and (out / "checkpoint.json").exists()
            )
        except (SafetyStopError, LinkError, BadInputError) as problem:
            problems.append(str(problem))
            time.sleep(0.5)
    raise AssertionError(problems)


def through_daemon(tmp_path: Path, experiment: Experiment) -> Outcome:
    with RunningDaemon(tmp_path / "daemon", "--config", str(configuration(tmp_path, "serial"))) as daemon:
        plant = RunningPlant(tmp_path, "serial")
        try:
            outcome = conducted_in_spite_of_stalls(experiment, daemon, tmp_path / "experiment")
            with daemon.client() as client:
                assert daemon.until_state(client, "idle")["torque_nm"] == {"outer": 0.0, "inner": 0.0}
                client.request("shut_down")
            daemon.wait()
        finally:
            plant.end(signal.SIGTERM)
    return outcome


@pytest.mark.heavy
def test_a_small_sequence_through_the_daemon_measures_what_it_measures_in_lockstep(tmp_path: Path) -> None:
    real = through_daemon(tmp_path, small_sequence())
    run = Run(real.folder)
    assert run.replays() and not list(damage_of(run.log))
    table = run.table()
    assert len(table) >= len(run.log.ticks) - 3  # a period that the machine missed is a row too
    assert all(np.isfinite(values).all() for values in table.columns.values())
    virtual = conduct(small_sequence(), shipped_settings(), shipped_model(), 1, tmp_path / "lockstep")
    assert [row["step"] for row in real.rows] == [row["step"] for row in virtual.rows]
    for one, other in zip(real.rows, virtual.rows, strict=True):
        assert one["rate_rad_s"] == pytest.approx(other["rate_rad_s"], rel=0.02)
        assert one["torque_nm"] == pytest.approx(other["torque_nm"], rel=0.05)


@pytest.mark.heavy
@pytest.mark.parametrize("axis", ["outer", "inner"])
def test_short_sliding_and_presliding_through_daemon_and_plant_give_the_parameters_of_the_model(
    tmp_path: Path, axis: str
) -> None:
    from gimbal_hil.knowledge.identification import Log, friction_of, identify_axis
    from gimbal_hil.knowledge.identification.reading import read_logs

    model = shipped_model()
    logs: list[Log] = []
    for name in ("sliding", "presliding"):
        folder = tmp_path / name
        folder.mkdir()
        options = SequenceOptions(1000.0, (axis,), short=True, breakaway_nm=breakaway_torques(model))
        outcome = through_daemon(folder, build_experiment(name, options))
        logs += read_logs(outcome.folder, model.axes)
    found = identify_axis(logs, model, axis)
    truth = dict(zip((e.name for e in found.estimates), friction_of(model, axis).values().tolist(), strict=True))
    for estimate in found.estimates:
        low, high = estimate.interval.low, estimate.interval.high
        held = estimate.interval.covers(truth[estimate.name])
        print(
            f"{estimate.name:<18} {estimate.value:.6g} ({low:.6g} to {high:.6g}), true {truth[estimate.name]:.6g}, "
            f"held: {held}"
        )
        assert np.isfinite(high - low)
        assert abs(estimate.value - truth[estimate.name]) < max(high - low, 0.02 * truth[estimate.name])
