"""Every command of `gimbal-hil`: in which group `--help` shows it, where it is defined, and its one line.

Nothing of a command is imported before it is asked for.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType


@dataclass(frozen=True)
class CommandEntry:
    """A command. `place` is a module beside this one; it defines `command`, a function with typer's annotations, or the
    function named after a colon. `compiles`: it may meet a kernel that is not on disk yet, and shows that.
    """

    place: str
    line: str
    compiles: bool = False


#: by what they are for, in the order in which --help shows them
GROUPS: dict[str, dict[str, CommandEntry]] = {
    "Begin": {
        "demo": CommandEntry(
            "demo", "A demonstration of the whole workflow on the virtual antenna in under two minutes.", compiles=True
        ),
        "init": CommandEntry("init", "Files of an antenna of your own: configuration, model, plan, next commands."),
        "check": CommandEntry(
            "check", "Check configuration, model, plan or data files: every error with its key.", compiles=True
        ),
        "doctor": CommandEntry("doctor", "Can this machine hold the rate? A verdict with reasons."),
        "warm": CommandEntry(
            "warm", "Compile everything now, so that no later command has to wait for it.", compiles=True
        ),
    },
    "Operate an antenna": {
        "daemon": CommandEntry(
            "daemon", "Run the fixed-rate control daemon on the link that the configuration names.", compiles=True
        ),
        "watch": CommandEntry("watch", "A running daemon in the terminal: state, axes, torque, misses, recording."),
        "set": CommandEntry("operate:set_axes", "Move the axes of a running daemon: azimuth=0.5 elevation=-0.3."),
        "adjust": CommandEntry(
            "adjust", "Gains and limits of a running daemon: show them, change them within their bounds, take back."
        ),
        "point": CommandEntry(
            "point", "Hold a direction in space, a satellite or a list of directions from a moving base.", compiles=True
        ),
        "stop": CommandEntry("operate:stop", "Brake both axes to rest, torque off; the daemon stays connected."),
        "quick-stop": CommandEntry(
            "operate:quick_stop", "The drive brakes both axes by itself, with torque, holds them, then switches off."
        ),
        "reset": CommandEntry("operate:reset", "Leave a fault and connect anew."),
        "shut-down": CommandEntry("operate:shut_down", "Brake to rest, then end the daemon."),
        "plant": CommandEntry(
            "plant", "Serve the virtual antenna's frames on a serial, slcan or Unix-socket link.", compiles=True
        ),
        "foxglove": CommandEntry(
            "foxglove", "A running daemon, live, for Foxglove and PlotJuggler: signals, state, events, 3-D."
        ),
        "mavlink": CommandEntry(
            "mavlink", "A running daemon as a gimbal for autopilots and ground stations: MAVLink's protocol v2."
        ),
    },
    "Measure and find out": {
        "testable": CommandEntry(
            "testable",
            "Before recording: which effects a run could show, from which size, and which pairs it cannot tell apart.",
            compiles=True,
        ),
        "experiment": CommandEntry(
            "experiment",
            "Run a sequence: step, sliding, presliding, gravity_map, sweep, base_motion, thesis or a plan file.",
            compiles=True,
        ),
        "identify": CommandEntry(
            "identify", "Friction parameters with confidence intervals, into a new model file.", compiles=True
        ),
        "discrepancy": CommandEntry(
            "discrepancy",
            "Find where model and measurement disagree, name what is missing, add it, show the gap shrink.",
            compiles=True,
        ),
        "improve": CommandEntry(
            "improve",
            "Experiment, diagnose and correct until the model is at the noise floor or has to give up.",
            compiles=True,
        ),
        "changed": CommandEntry(
            "changed", "What differs between two units, days or settings: numbers, effects, or nothing.", compiles=True
        ),
        "campaign": CommandEntry(
            "campaign",
            "One experiment on many virtual antennas that differ in their numbers: one table.",
            compiles=True,
        ),
        "joint": CommandEntry(
            "joint", "One joint of an arm as a log of its own: the other links' torque, by a URDF, subtracted."
        ),
    },
    "Use a model": {
        "effects": CommandEntry(
            "effects", "The catalogue of effects: parameters, units, bounds, and the run that excites each."
        ),
        "tune": CommandEntry("tune", "Gains, observers and feed-forward for a model, with margins kept."),
        "drive-tables": CommandEntry(
            "drive_tables",
            "Ripple and friction of a model as tables that moteus, ODrive and CiA 402 drives take.",
            compiles=True,
        ),
        "export-model": CommandEntry(
            "export_model",
            "A model for other simulators: MuJoCo, URDF, Isaac Lab, BAM, curves; what they cannot hold is listed.",
        ),
    },
    "Recorded runs": {
        "runs": CommandEntry("runs", "List recorded runs, show one, or compare two side by side."),
        "replay": CommandEntry(
            "replay",
            "Re-run a recorded run against its frames: identical, or the first tick and signal that differ.",
            compiles=True,
        ),
        "export": CommandEntry("export", "Write a run as Parquet, CSV, MAT, MCAP, BLF, MF4 or a bag of ROS 2."),
    },
    "Build and prove": {
        "conformance": CommandEntry(
            "conformance", "Check an antenna's firmware against numbered requirements, with evidence.", compiles=True
        ),
        "protocol": CommandEntry("protocol", "Emit the wire definition as DBC, C header or documentation."),
        "service": CommandEntry("service", "Write a systemd unit, a container file, a Grafana dashboard or man pages."),
        "bench": CommandEntry(
            "bench",
            "Figures: speed beside a plain reference, deadlines, faults, controllers in the arena.",
            compiles=True,
        ),
    },
}
COMMANDS: dict[str, CommandEntry] = {name: one for group in GROUPS.values() for name, one in group.items()}


def function_of(name: str) -> tuple[ModuleType, Callable[..., int]]:
    """The module of a command and the function in it that answers."""
    place, _, function = COMMANDS[name].place.partition(":")
    loaded = importlib.import_module(f"{__package__}.{place}")
    from gimbal_hil.surface.cli.option_groups import with_groups

    return loaded, with_groups(getattr(loaded, function or "command"))
