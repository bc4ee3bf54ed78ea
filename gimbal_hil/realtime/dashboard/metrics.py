"""What a running daemon shows Prometheus, in its text format, written by prometheus-client (extra `metrics`)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gimbal_hil.loop.host import HostState, LinkStatus
from gimbal_hil.loop.timing import Histogram
from gimbal_hil.realtime.observing import WatchState
from gimbal_hil.realtime.telemetry import LiveView

#: upper bounds of the exported buckets, microseconds
_BOUNDS_US = (10, 20, 50, 100, 200, 500, 1_000, 2_000, 5_000, 10_000, 50_000, 200_000, 1_000_000)
#: how recording may stand
LAMPS = ("ok", "low", "stopping", "failed")
CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"


def metrics_text(view: LiveView) -> bytes | None:
    """All metrics as one document; None when prometheus-client is not installed."""
    try:
        from prometheus_client import CollectorRegistry, generate_latest
    except ModuleNotFoundError:
        return None
    registry = CollectorRegistry(auto_describe=False)
    registry.register(_Collector(view))
    return bytes(generate_latest(registry))


class _Collector:
    """Reads the view when asked, so that nothing is counted twice."""

    def __init__(self, view: LiveView) -> None:
        self._view = view

    def collect(self) -> Iterator[Any]:
        """The metric families of prometheus-client."""
        from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily

        view, status = self._view, self._view.status()
        yield CounterMetricFamily("gimbal_ticks", "Ticks that ran.", value=view.ticks)
        missed = CounterMetricFamily("gimbal_missed_ticks", "Periods that were skipped, by cause.", labels=["cause"])
        for cause, count in view.misses_by_cause.items():
            missed.add_metric([cause.value], count)
        yield missed
        yield CounterMetricFamily(
            "gimbal_rejected_frames", "Received frames dropped by CRC, counter or bounds.", value=view.rejected_frames
        )
        yield _histogram("gimbal_wake_latency_seconds", "From deadline to wake-up.", view.latency)
        yield _histogram(
            "gimbal_computing_seconds", "From wake-up to the frames sent and the row handed over.", view.computing
        )
        for name, text, kind, now in (
            ("gimbal_host_state", "1 for the state that the host is in.", HostState, status["host_state"]),
            ("gimbal_link_status", "1 for the status of the feedback.", LinkStatus, status["link"]),
        ):
            family = GaugeMetricFamily(name, text, labels=["state"])
            for state in kind:
                family.add_metric([state.name.lower()], float(state.name.lower() == now))
            yield family
        muted = float(status["pointing"]["muted"])
        yield GaugeMetricFamily("gimbal_pointing_muted", "1 unless the antenna looks where it should.", value=muted)
        yield from _lamps(view)
        for key in ("position_rad", "rate_rad_s", "torque_nm"):
            family = GaugeMetricFamily(f"gimbal_{key}", "Last measured value (torque: commanded).", labels=["axis"])
            for axis in view.axes:
                if status[key][axis] is not None:
                    family.add_metric([axis], status[key][axis])
            yield family
        wire = status["wire"]
        for name, text, value in (
            (
                "gimbal_deadman_margin_ticks",
                "Least margin of the drive's deadman lately.",
                wire["deadman_margin_ticks"],
            ),
            ("gimbal_bus_load_ratio", "Share of the bus that frames took in the last second.", wire["bus_load"]),
        ):
            yield GaugeMetricFamily(name, text, value=value)
        lacks = GaugeMetricFamily(
            "gimbal_missing_torque_nm",
            "Torque that the model beside the antenna lacks, rms of a second.",
            labels=["axis"],
        )
        changed = GaugeMetricFamily("gimbal_model_changed", "1 where it lacks more than usual.", labels=["axis"])
        suspected = GaugeMetricFamily(
            "gimbal_model_suspicion", "Probability of what seems to grow.", labels=["axis", "cause"]
        )
        for axis, one in status["observer"].get("axes", {}).items():
            if one["rms_nm"] is not None:
                lacks.add_metric([axis], one["rms_nm"])
            changed.add_metric([axis], float(one["state"] == WatchState.CHANGED))
            if one.get("suspected") is not None:
                suspected.add_metric([axis, one["suspected"]["cause"]], one["suspected"]["probability"])
        yield lacks
        yield changed
        yield suspected


def _lamps(view: LiveView) -> Iterator[Any]:
    """Which guard has tripped, how often each one did, and whether what happens is recorded."""
    from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily

    tripped = GaugeMetricFamily("gimbal_guard_tripped", "1 for the guard that stops the axes now.", labels=["guard"])
    trips = CounterMetricFamily("gimbal_guard_trips", "How often each guard has tripped.", labels=["guard"])
    for guard, count in view.trips.items():
        tripped.add_metric([guard], float(guard == view.guard))
        trips.add_metric([guard], count)
    yield tripped
    yield trips
    recording = view.recording()
    lamp = GaugeMetricFamily(
        "gimbal_recording_lamp", "1 for how recording stands; low, stopping: the disk fills.", labels=["lamp"]
    )
    for name in LAMPS:
        lamp.add_metric([name], float(name == recording.get("lamp")))
    yield lamp
    free_mb = recording.get("free_mb")
    text = "Room on the disk that the run is recorded on."
    yield GaugeMetricFamily("gimbal_recording_free_bytes", text, value=free_mb and free_mb * float(1 << 20))


def _histogram(name: str, text: str, histogram: Histogram) -> Any:
    from prometheus_client.core import HistogramMetricFamily

    counts = histogram.cumulative(tuple(bound * 1000 for bound in _BOUNDS_US))
    buckets = [(str(bound / 1e6), float(count)) for bound, count in zip(_BOUNDS_US, counts, strict=True)]
    family = HistogramMetricFamily(name, text)
    family.add_metric([], [*buckets, ("+Inf", float(histogram.count))], histogram.total_ns / 1e9)
    return family
