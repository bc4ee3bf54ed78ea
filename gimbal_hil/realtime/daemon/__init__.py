"""The control daemon: control process, link and its loss, what is reported at the end."""

from gimbal_hil.realtime.daemon.link_check import check_link
from gimbal_hil.realtime.daemon.run import DaemonOptions, DaemonReport, run_daemon
from gimbal_hil.realtime.daemon.summary import summary_lines

__all__ = [
    "DaemonOptions",
    "DaemonReport",
    "check_link",
    "run_daemon",
    "summary_lines",
]
