"""The systemd unit of the daemon: told when ticks run, watched, real-time limits, and no more rights than it needs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from firmware_protocol.errors import EXIT_BAD_INPUT, EXIT_INTERRUPTED, EXIT_SAFETY_STOP

UNIT_NAME = "gimbal-hil.service"
#: below it systemd itself makes the folder, for the unit's user
_STATE = Path("/var/lib")


@dataclass(frozen=True)
class UnitChoice:
    """What a unit is made of. `program` is the absolute path of `gimbal-hil`; `user` owns runs and devices."""

    program: Path
    config: Path
    runs: Path
    user: str
    page_port: int | None = None
    watchdog_s: int = 10
    #: where the manual is, as systemd writes it
    manual: str = "man:gimbal-hil(1)"


def plain(path: Path) -> str:
    """A path where systemd takes the rest of the line as it is, but for its specifiers."""
    return str(path).replace("%", "%%")


def word(path: Path, before: str = "") -> str:
    """A path as one word of a line: quoted, with what systemd would read otherwise escaped (systemd.syntax(7))."""
    text = str(path).replace("\\", "\\\\").replace('"', '\\"').replace("$", "$$")
    return f'"{before}{plain(Path(text))}"'


def unit_text(choice: UnitChoice) -> str:
    """The unit file.

    No shell stands between systemd and the daemon, so that a file may be called anything. Runs are new folders below
    `runs` of the working folder, where `gimbal-hil watch`, `stop` and the like look for them. `--wait`: a device that
    comes up later than this unit is waited for, as is a bus. `NotifyAccess=all` because the process beside the control
    loop speaks for it. Memory that is both writable and executable stays allowed: kernels are compiled in it.
    """
    page = "" if choice.page_port is None else f" --page {choice.page_port}"
    program, runs = word(choice.program), plain(choice.runs)
    if choice.runs.is_relative_to(_STATE):
        state = f"StateDirectory={word(choice.runs.relative_to(_STATE))}\nStateDirectoryMode=0750"
    else:
        # with all rights, before the daemon's own few
        state = f"ExecStartPre=+/usr/bin/install -d -m 0750 -o {choice.user} {word(choice.runs)}"
    return f"""# Written by `gimbal-hil service install`. The drive's own deadman, not this unit, makes a stop safe.
[Unit]
Description=gimbal-hil control daemon
Documentation={choice.manual.replace("%", "%%")}
After=network.target
StartLimitIntervalSec=60
StartLimitBurst=3

[Service]
Type=notify
NotifyAccess=all
{state}
ExecStartPre={program} warm
ExecStart={program} daemon --wait --config {word(choice.config)}{page}
# compiling in ExecStartPre, the first time
TimeoutStartSec=900
WatchdogSec={choice.watchdog_s}
# brakes to rest and closes the log
KillSignal=SIGTERM
KillMode=mixed
TimeoutStopSec=30
# 130 is the end that a signal asked for; 3 is a safety stop: a person looks first; 2 is a bad configuration
SuccessExitStatus={EXIT_INTERRUPTED}
Restart=on-failure
RestartPreventExitStatus={EXIT_BAD_INPUT} {EXIT_SAFETY_STOP}
RestartSec=2

User={choice.user}
SupplementaryGroups=dialout
WorkingDirectory=-{runs}
CacheDirectory=gimbal-hil
Environment=GIMBAL_HIL_CACHE=%C/gimbal-hil
# where the operator's socket is: PrivateTmp would hide it from whoever operates
RuntimeDirectory=gimbal-hil
RuntimeDirectoryMode=0700
Environment=XDG_RUNTIME_DIR=%t/gimbal-hil

LimitRTPRIO=95
LimitMEMLOCK=infinity
LimitNICE=-20
AmbientCapabilities=CAP_SYS_NICE CAP_IPC_LOCK
CapabilityBoundingSet=CAP_SYS_NICE CAP_IPC_LOCK

NoNewPrivileges=yes
ProtectSystem=strict
ReadWritePaths={word(choice.runs, "-")}
ProtectHome=read-only
PrivateTmp=yes
ProtectKernelTunables=yes
ProtectKernelModules=yes
ProtectKernelLogs=yes
ProtectControlGroups=yes
ProtectClock=yes
ProtectHostname=yes
RestrictNamespaces=yes
RestrictSUIDSGID=yes
LockPersonality=yes
# CAN and Unix sockets; the live page is on the loopback address
RestrictAddressFamilies=AF_UNIX AF_CAN AF_INET AF_NETLINK
SystemCallArchitectures=native
UMask=0027

[Install]
WantedBy=multi-user.target
"""
