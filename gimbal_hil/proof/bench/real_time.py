"""Real time: plant and daemon as two processes over a real driver stack, beside a C loop of the same policy in the same
minutes.

The two take turns of `SLICE_S` on the same core, so that both see the same machine. While the daemon has its turn it
records every frame and serves its page and metrics, which are read once a second, and both axes follow sines.
"""

from __future__ import annotations

import json
import subprocess
import tempfile
import time
import urllib.request
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firmware_protocol.errors import BadInputError, GimbalHilError
from firmware_protocol.json_object import Json
from gimbal_hil.data.runs import EventKind, open_run
from gimbal_hil.loop.host import HostState, word_of
from gimbal_hil.loop.timing import Duration, Histogram, MissCause, ReferenceLoop, compiler
from gimbal_hil.proof.bench.two_processes import begun, running_plant, two_process_configuration
from gimbal_hil.realtime.operator import OperatorClient

#: a daemon's turn and the C loop's, idle and at work, s
SLICE_S, REFERENCE_SLICE_S = 30.0, 10.0
#: p99 of the wake-up latency over that of the C loop, and p99 of computing up to this rate
ASKED_RATIO, ASKED_COMPUTING_US, ASKED_AT_HZ = 1.5, 100.0, 1000.0
#: causes that are the daemon's own; a wait for the bus is the driver's, all others are the machine's
OWN = (MissCause.OWN_COMPUTING, MissCause.GARBAGE_COLLECTION, MissCause.PAGE_FAULT)
_START_S = 300.0
_LOOK_S = 1.0
_SINE = {"mode": "position", "shape": "sine", "parameters": [0.0, 0.5, 0.3, 0.0]}


@dataclass
class RealTime:
    """What one link at one rate showed. Latencies and computing in nanoseconds; misses of the daemon by cause, of the C
    loop in all.
    """

    link: str
    rate_hz: float
    latency: Histogram = field(default_factory=Histogram)
    computing: Histogram = field(default_factory=Histogram)
    reference: Histogram = field(default_factory=Histogram)
    missed: dict[MissCause, int] = field(default_factory=lambda: dict.fromkeys(MissCause, 0))
    reference_missed: int = 0
    #: of the C loop that works as long as the daemon usually computes, always the same: ticks, and those missed because
    #: it took longer
    working_ticks: int = 0
    stretched: int = 0
    #: what the log says of every miss of the daemon's own
    own_evidence: list[Json] = field(default_factory=list)
    #: p99 of the daemon's wake-ups over that of the C loop, turn by turn
    ratios: list[float] = field(default_factory=list)
    ready_s: list[float] = field(default_factory=list)
    #: how often motion was interrupted by a guard (a stall of the machine ends it) and taken up again
    interruptions: int = 0

    @property
    def own_misses(self) -> int:
        """Ticks missed for a reason of the daemon's own."""
        return sum(self.missed[cause] for cause in OWN)

    @property
    def ratio(self) -> float:
        """p99 of all wake-ups over that of the C loop."""
        return self.latency.quantile_ns(0.99) / max(1, self.reference.quantile_ns(0.99))

    @property
    def problem(self) -> str:
        """Which targets are missed, and by what; empty where none is."""
        computing_us = self.computing.quantile_ns(0.99) / 1e3
        missed = []
        if self.own_misses:
            missed.append(f"{self.own_misses} own misses, target 0")
        if self.ratio > ASKED_RATIO:
            missed.append(f"p99 ratio {self.ratio:.3g}, target at most {ASKED_RATIO:g}")
        if self.rate_hz <= ASKED_AT_HZ and computing_us >= ASKED_COMPUTING_US:
            missed.append(f"computing p99 {computing_us:.0f} us, target under {ASKED_COMPUTING_US:g}")
        return f"{self.link} {self.rate_hz:g} Hz: {'; '.join(missed)}" if missed else ""

    def as_dict(self) -> Json:
        """For JSON, in microseconds."""
        return {
            "problem": self.problem,
            "link": self.link,
            "rate_hz": self.rate_hz,
            "ticks": self.latency.count,
            "latency_us": self.latency.summary_us(),
            "c_loop_latency_us": self.reference.summary_us(),
            "p99_ratio_to_c": self.ratio,
            "p99_ratio_by_turn": self.ratios,
            "computing_us": self.computing.summary_us(),
            "missed_by_cause": {cause.value: count for cause, count in self.missed.items()},
            "own_misses": self.own_misses,
            "own_evidence": self.own_evidence,
            "c_loop_missed": self.reference_missed,
            "c_loop_at_work": {"ticks": self.working_ticks, "missed_at_work": self.stretched},
            "ready_s": self.ready_s,
            "interruptions": self.interruptions,
        }


def real_time_figures(
    links: tuple[str, ...], rates_hz: tuple[float, ...], seconds: float, say: Callable[[str], None]
) -> list[RealTime]:
    """Every link at every rate for `seconds` of the daemon's time; BadInputError without a C compiler."""
    if compiler() is None:
        raise BadInputError("bench realtime", "there is no C compiler for the reference loop", "gcc or cc in the path")
    found = []
    for link in links:
        for rate_hz in rates_hz:
            say(f"{link} at {rate_hz:g} Hz for {seconds:g} s")
            found.append(_measured(link, rate_hz, seconds))
    return found


def _measured(link: str, rate_hz: float, seconds: float) -> RealTime:
    result = RealTime(link, rate_hz)
    turns = max(1, round(seconds / SLICE_S))
    with tempfile.TemporaryDirectory(prefix="gimbal-hil-") as name, ReferenceLoop() as loop:
        folder = Path(name)
        configuration = two_process_configuration(folder, link, rate_hz)
        with running_plant(configuration):
            for turn in range(turns):
                wakes, granted = _daemon_turn(folder / f"run_{turn}", configuration, seconds / turns, result)
                reference = _reference_turn(loop, granted, min(seconds / turns, REFERENCE_SLICE_S), result)
                result.ratios.append(wakes.quantile_ns(0.99) / max(1, reference.quantile_ns(0.99)))
    return result


def _reference_turn(loop: ReferenceLoop, granted: Json, seconds: float, result: RealTime) -> Histogram:
    """The C loop with what the kernel granted the daemon: idle, for the wake-ups, and at work, for what the machine
    takes from that.
    """
    period, ticks = Duration.of_seconds(1.0 / result.rate_hz), round(seconds * result.rate_hz)
    priority, core = granted["real_time_priority"], granted["core"]
    idle = loop.run(period, ticks, priority, core)
    result.reference.merge(idle.latency)
    result.reference_missed += idle.missed
    at_work = loop.run(period, ticks, priority, core, Duration(result.computing.quantile_ns(0.5)))
    result.working_ticks += at_work.latency.count
    result.stretched += at_work.stretched
    return idle.latency


def _daemon_turn(run: Path, configuration: Path, seconds: float, result: RealTime) -> tuple[Histogram, Json]:
    """One daemon from start to end; answers its wake-up latencies and what the kernel granted it."""
    began = time.monotonic()
    words = [
        "daemon",
        "--config",
        str(configuration),
        "--out",
        str(run),
        "--duration",
        f"{seconds:g}",
        "--page",
        "0",
        "--json",
    ]
    with (run.parent / "daemon.err").open("w+") as said:
        daemon = begun(words, said)
        try:
            _keep_busy(run, daemon, began, result)
            answer = json.loads(daemon.communicate()[0])
        finally:
            if daemon.poll() is None:
                daemon.kill()
                daemon.wait()
    for cause, count in answer["ticks"]["missed_by_cause"].items():
        result.missed[MissCause(cause)] += count
    recorded = open_run(run)
    own = {cause.value for cause in OWN}
    result.own_evidence += [
        dict(event.data) for event in recorded.events if event.kind is EventKind.TIMING and event.data["cause"] in own
    ]
    rows = recorded.ticks
    # a row tells how late it was for its own deadline; the C loop's figures count from the deadline that was missed
    late_ns = rows["wake_latency_ns"] + rows["skipped_ticks"].astype(np.int64) * round(1e9 / result.rate_hz)
    latency, computing = _histogram(late_ns), _histogram(rows["computing_ns"])
    result.latency.merge(latency)
    result.computing.merge(computing)
    return latency, answer["real_time"]


def _keep_busy(run: Path, daemon: subprocess.Popen[str], began: float, result: RealTime) -> None:
    """Keep the axes on their sines and read page and metrics once a second until the daemon has ended."""
    while not (run / "operator.json").exists():
        if daemon.poll() is not None or time.monotonic() - began > _START_S:
            raise GimbalHilError((run.parent / "daemon.err").read_text().strip() or "the daemon did not start")
        time.sleep(0.01)
    with suppress(GimbalHilError, OSError), OperatorClient(run, timeout_s=5.0) as operator:
        while not operator.request("status")["status"]["tick"]:
            time.sleep(0.01)
        result.ready_s.append(time.monotonic() - began)
        page = next(
            (line.split()[-1] for line in (run.parent / "daemon.err").read_text().splitlines() if "live page" in line),
            None,
        )
        while daemon.poll() is None:
            state = operator.request("status")["status"]["host_state"]
            if state == word_of(HostState.IDLE):
                operator.when_ready(
                    "segments", segments=[{"outer": _SINE, "inner": _SINE, "duration_s": 1e6, "label": 1}]
                )
            elif state == word_of(HostState.FAULT):
                result.interruptions += 1
                operator.request("fault_reset")
            if page is not None:
                for path in ("live.json", "metrics"):
                    with urllib.request.urlopen(f"{page.rstrip('/')}/{path}", timeout=5.0) as answer:
                        answer.read()
            time.sleep(_LOOK_S)


def _histogram(values_ns: NDArray[np.integer]) -> Histogram:
    histogram = Histogram()
    for value in values_ns.tolist():
        histogram.add(value)
    return histogram
