"""The systemd unit of the daemon: told when ticks run, watched, real-time limits, and no more rights than it needs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

UNIT_NAME = "gimbal-hil.service"


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


def unit_text(choice: UnitChoice) -> str:
    """The unit file.

    A run folder is named after the time of the start. `NotifyAccess=all` because the process beside the control loop
    speaks for it. Memory that is both writable and executable stays allowed: kernels are compiled in it.
    """
    page = "" if choice.page_port is None else f" --page {choice.page_port}"
    # %% is a percent sign for systemd, $$ a dollar sign
    folder = f'"{choice.runs}/$$(date -u +%%Y%%m%%dT%%H%%M%%S)"'
    command = f"exec {choice.program} daemon --config {choice.config}{page} --out {folder}"
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
ExecStartPre={choice.program} warm
ExecStart=/bin/sh -c '{command}'
# compiling in ExecStartPre, the first time
TimeoutStartSec=900
WatchdogSec={choice.watchdog_s}
# brakes to rest and closes the log
KillSignal=SIGTERM
KillMode=mixed
TimeoutStopSec=30
# 3 is a safety stop: a person looks first; 2 is a bad configuration
Restart=on-failure
RestartPreventExitStatus=2 3
RestartSec=2

User={choice.user}
SupplementaryGroups=dialout
WorkingDirectory={choice.runs}
CacheDirectory=gimbal-hil
Environment=GIMBAL_HIL_CACHE=%C/gimbal-hil

LimitRTPRIO=95
LimitMEMLOCK=infinity
LimitNICE=-20
AmbientCapabilities=CAP_SYS_NICE CAP_IPC_LOCK
CapabilityBoundingSet=CAP_SYS_NICE CAP_IPC_LOCK

NoNewPrivileges=yes
ProtectSystem=strict
ReadWritePaths={choice.runs}
ProtectHome=read-only
PrivateTmp=yes
ProtectKernelTunables=yes
ProtectKernelModules=yes
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
