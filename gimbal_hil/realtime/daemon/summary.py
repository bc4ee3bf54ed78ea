"""The last lines that `gimbal-hil daemon` prints."""

from __future__ import annotations

from gimbal_hil.realtime.daemon.run import DaemonReport


def summary_lines(report: DaemonReport) -> list[str]:
    """How the run ended, what the ticks and the frames were like."""
    statistics, frames = report.statistics, report.frames
    latency, computing = statistics.latency.summary_us(), statistics.computing.summary_us()
    causes = ", ".join(f"{cause.value} {count}" for cause, count in statistics.misses_by_cause.items() if count)
    bad = frames["crc_errors"] + frames["out_of_range"] + frames["duplicates"] + frames["foreign"]
    lines = [
        f"ended: {report.ending.reason} (exit code {report.ending.exit_code})",
        f"ticks: {statistics.ticks} run, {statistics.missed} missed{f' ({causes})' if causes else ''},"
        f" longest stall {statistics.longest_stall_ns / 1e6:.1f} ms",
    ]
    for name, row in (("wake-up latency", latency), ("own computing", computing)):
        lines.append(
            f"{name}: p50 {row['p50']:.0f} us, p99 {row['p99']:.0f} us, p99.9 {row['p999']:.0f} us, largest "
            f"{row['max']:.0f} us"
        )
    lines.append(
        f"frames: {frames['good']} good, {bad} dropped, {frames['lost']} lost; link lost {report.link_losses} times"
    )
    if report.granted is not None and report.granted.refused:
        lines += [f"not granted: {line}" for line in report.granted.refused]
    lines.append(f"run folder: {report.run}" + ("" if report.recorded else " (recording ended early)"))
    return lines
