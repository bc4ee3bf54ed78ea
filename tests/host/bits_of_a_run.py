"""Prints digests of what host and virtual antenna do in a short run, mail to mail and frame to frame; run with and
without the compiler.
"""

from __future__ import annotations

import hashlib

from gimbal_hil.loop.host import AxisCommand, Mode, ReferenceOrigin, Segment, Shape, program_of
from gimbal_hil.loop.settings import shipped_settings
from gimbal_hil.realtime.lockstep import CompiledPath, FramePath, joined
from sim_backend.model import shipped_model


def digest_of_run() -> str:
    """SHA-256 of log, events and final state."""
    path = CompiledPath(shipped_settings(), shipped_model(), seed=5)
    first = Segment(
        AxisCommand(Mode.POSITION, Shape.SINE, (0.0, 0.2, 3.0, 0.1)),
        AxisCommand(Mode.RATE, Shape.CHIRP, (0.0, 0.2, 1.0, 2.0, 5.0)),
        40,
    )
    second = Segment(
        AxisCommand(Mode.INERTIAL_RATE, Shape.PULSES, (0.0, 0.1, 0.02, 0.01, 1.0, 9.0)), AxisCommand(Mode.TORQUE), 30
    )
    third = Segment(
        AxisCommand(Mode.POSITION, Shape.SMOOTH, (0.3, 0.1)),
        AxisCommand(Mode.POSITION, Shape.TRAPEZOID, (0.1, 1.0, 5.0), ReferenceOrigin.START),
        30,
    )
    fourth = Segment(
        AxisCommand(Mode.POSITION, Shape.TABLE, (0.01, 2.0), table=(0.0, 0.1, -0.1)),
        AxisCommand(Mode.RATE, Shape.RAMP, (0.0, 1.0, 0.5)),
    )
    parts = [path.connect(), path.run(program_of([first, second, third]))]
    path.host.command(program_of([fourth]))
    parts.append(path.advance(30))
    path.host.stop()
    parts.append(path.advance(30))
    whole = joined(parts)
    digest = hashlib.sha256(whole.log.tobytes() + repr(whole.events).encode())
    digest.update(
        path.host.memory.floats.tobytes()
        + path.host.memory.integers.tobytes()
        + path.device.X.tobytes()
        + path.device.drive_words.tobytes()
    )
    return digest.hexdigest()


def digest_over_frames() -> str:
    """SHA-256 of log and final state of a run whose host and antenna hear each other as frames."""
    path = FramePath(shipped_settings(), shipped_model(), seed=5)
    sine = AxisCommand(Mode.POSITION, Shape.SINE, (0.0, 0.2, 3.0, 0.1))
    whole = joined([path.connect(), path.run(program_of([Segment(sine, AxisCommand(Mode.RATE), 60)]))])
    digest = hashlib.sha256(whole.log.tobytes() + repr(whole.events).encode())
    digest.update(path.host.memory.integers.tobytes() + path.device.drive_words.tobytes())
    return digest.hexdigest()


if __name__ == "__main__":
    print(digest_of_run(), digest_over_frames())
