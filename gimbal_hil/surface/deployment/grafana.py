"""A Grafana dashboard of what `/metrics` tells."""

from __future__ import annotations

import json

#: title, unit as Grafana calls it, queries with their legends
_PANELS = (
    ("Position", "radian", (("gimbal_position_rad", "{{axis}}"),)),
    ("Rate", "rads", (("gimbal_rate_rad_s", "{{axis}}"),)),
    ("Torque", "none", (("gimbal_torque_nm", "{{axis}} N m"),)),
    ("Host state", "none", (("gimbal_host_state == 1", "{{state}}"),)),
    ("Link", "none", (("gimbal_link_status == 1", "{{state}}"),)),
    ("Missed ticks by cause", "cps", (("rate(gimbal_missed_ticks_total[1m])", "{{cause}}"),)),
    (
        "Late by",
        "s",
        tuple(
            (f"histogram_quantile({q}, sum by (le) (rate(gimbal_wake_latency_seconds_bucket[1m])))", f"p{100 * q:g}")
            for q in (0.5, 0.99, 0.999)
        ),
    ),
    (
        "Computing",
        "s",
        (("histogram_quantile(0.99, sum by (le) (rate(gimbal_computing_seconds_bucket[1m])))", "p99"),),
    ),
    ("Torque that the model lacks", "none", (("gimbal_missing_torque_nm", "{{axis}} N m"),)),
    ("Deadman margin", "none", (("gimbal_deadman_margin_ticks", "ticks"),)),
    ("Bus load", "percentunit", (("gimbal_bus_load_ratio", "share"),)),
    ("Guards tripped", "none", (("increase(gimbal_guard_trips_total[1m])", "{{guard}}"),)),
    ("Room for recording", "bytes", (("gimbal_recording_free_bytes", "free"),)),
    ("Frames rejected", "cps", (("rate(gimbal_rejected_frames_total[1m])", "rejected"),)),
)
_WIDTH, _HEIGHT = 8, 7


def grafana_dashboard() -> str:
    """JSON to import; it asks for the Prometheus that scrapes `http://127.0.0.1:PORT/metrics`."""
    source = {"type": "prometheus", "uid": "${DS_PROMETHEUS}"}
    panels: list[dict[str, object]] = [
        {
            "id": place + 1,
            "type": "timeseries",
            "title": title,
            "datasource": source,
            "gridPos": {"x": _WIDTH * (place % 3), "y": _HEIGHT * (place // 3), "w": _WIDTH, "h": _HEIGHT},
            "fieldConfig": {"defaults": {"unit": unit}, "overrides": []},
            "targets": [
                {"refId": chr(ord("A") + n), "expr": query, "legendFormat": legend, "datasource": source}
                for n, (query, legend) in enumerate(queries)
            ],
        }
        for place, (title, unit, queries) in enumerate(_PANELS)
    ]
    document = {
        "__inputs": [{"name": "DS_PROMETHEUS", "label": "Prometheus", "type": "datasource", "pluginId": "prometheus"}],
        "title": "gimbal-hil",
        "uid": "gimbal-hil",
        "schemaVersion": 39,
        "refresh": "5s",
        "time": {"from": "now-15m", "to": "now"},
        "panels": panels,
    }
    return json.dumps(document, indent=2) + "\n"


def queried_metrics() -> set[str]:
    """Names of the metrics that the panels ask for, as Prometheus stores them."""
    import re

    text = " ".join(query for _, _, queries in _PANELS for query, _ in queries)
    return set(re.findall(r"\bgimbal_\w+", text))
