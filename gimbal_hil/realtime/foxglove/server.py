"""Sends what a client of the daemon sees to whoever connects: Foxglove's websocket protocol, by its SDK."""

from __future__ import annotations

import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from gimbal_hil.realtime.foxglove.telling import (
    Quaternion,
    along_boresight,
    axis_message,
    log_level,
    rotations,
    state_message,
)
from gimbal_hil.realtime.operator import OperatorClient
from sim_backend.boresight import Boresight

_LOOPBACK = "127.0.0.1"
#: the antenna's bodies are sent again so often, for who connects late
_SCENE_EVERY_S = 1.0
_EXTRA = "pip install 'gimbal-hil[foxglove]'"


class FoxgloveServer:
    """Listens on the loopback address; times are those of the run, from its start on."""

    def __init__(self, axes: tuple[str, str], port: int) -> None:
        """`port` 0 takes any free one; BadInputError where it is taken or the SDK is not installed."""
        try:
            import foxglove
            from foxglove import channels
        except ImportError:
            raise BadInputError("foxglove", "the package foxglove-sdk is not installed", _EXTRA) from None
        self._axes = axes
        # without the context its channels are closed
        context = self._context = foxglove.Context()
        try:
            self._server = foxglove.start_server(name="gimbal-hil", host=_LOOPBACK, port=port, context=context)
        except (OSError, RuntimeError) as error:
            raise BadInputError("--port", f"port {port}: {error}", "a free port, or 0 for any") from None
        self._state = foxglove.Channel("/state", message_encoding="json", context=context)
        self._of_axis = {
            axis: foxglove.Channel(f"/axes/{axis}", message_encoding="json", context=context) for axis in axes
        }
        self._events = channels.LogChannel("/events", context=context)
        self._frames = channels.FrameTransformsChannel("/tf", context=context)
        self._scene = channels.SceneUpdateChannel("/antenna", context=context)
        self._scene_due_ns = -1

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._server.port)

    def tell(self, status: Json) -> None:
        """One `status` answer of the daemon."""
        from foxglove import messages

        now_ns = int(status["time_ns"])
        stamp = _stamp(now_ns)
        self._state.log(state_message(status), log_time=now_ns)
        for axis, channel in self._of_axis.items():
            channel.log(axis_message(status, axis), log_time=now_ns)
        transforms = [
            messages.FrameTransform(
                timestamp=stamp,
                parent_frame_id=parent,
                child_frame_id=frame,
                translation=messages.Vector3(),
                rotation=messages.Quaternion(x=x, y=y, z=z, w=w),
            )
            for frame, (parent, (x, y, z, w)) in rotations(status).items()
        ]
        self._frames.log(messages.FrameTransforms(transforms=transforms), log_time=now_ns)
        if now_ns >= self._scene_due_ns:
            self._scene_due_ns = now_ns + int(_SCENE_EVERY_S * 1e9)
            self._scene.log(_bodies(self._axes, Boresight(status["boresight"]), stamp), log_time=now_ns)

    def tell_event(self, event: Json) -> None:
        """One event of the daemon."""
        from foxglove import messages

        now_ns = int(event.get("time_ns", 0))
        level = getattr(messages.LogLevel, log_level(event))
        text, kind = str(event.get("text", "")), str(event.get("kind", ""))
        self._events.log(
            messages.Log(timestamp=_stamp(now_ns), level=level, message=f"{kind}: {text}", name="daemon"),
            log_time=now_ns,
        )

    def close(self) -> None:
        """Stop serving."""
        self._server.stop()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def serve(
    client: OperatorClient,
    server: FoxgloveServer,
    every_s: float,
    go_on: Callable[[], bool],
    clock_s: Callable[[], float] = time.monotonic,
) -> None:
    """Ask the service process of the daemon every so many seconds until `go_on` says no, or the daemon ends
    (LinkError). Nothing is ever commanded, and no tick waits for it.
    """
    while go_on():
        due_s = clock_s() + every_s
        server.tell(client.request("status")["status"])
        while (left_s := due_s - clock_s()) > 0.0:
            event = client.next_event(left_s)
            if event is not None and "text" in event:
                server.tell_event(event)


def _stamp(now_ns: int) -> Any:
    from foxglove import messages

    return messages.Timestamp(now_ns // 1_000_000_000, now_ns % 1_000_000_000)


def _bodies(axes: tuple[str, str], looks: Boresight, stamp: Any) -> Any:
    """Base, yoke, dish with its boresight along where it looks in the inner body, and the boresight of the reference;
    each moves with its own frame.
    """
    from foxglove import messages as made

    def pose(x: float = 0.0, y: float = 0.0, z: float = 0.0, turn: Quaternion = (0.0, 0.0, 0.0, 1.0)) -> Any:
        turned = made.Quaternion(x=turn[0], y=turn[1], z=turn[2], w=turn[3])
        return made.Pose(position=made.Vector3(x=x, y=y, z=z), orientation=turned)

    lying, pointing = along_boresight(looks)
    metal, dish = made.Color(r=0.6, g=0.64, b=0.7, a=1.0), made.Color(r=0.93, g=0.95, b=0.97, a=1.0)

    def boresight(red: float, green: float, blue: float) -> Any:
        colour = made.Color(r=red, g=green, b=blue, a=1.0)
        start = pose(looks.sign * 0.3, turn=pointing)
        return made.ArrowPrimitive(
            pose=start, shaft_length=1.0, shaft_diameter=0.02, head_length=0.12, head_diameter=0.06, color=colour
        )

    def cube(size: tuple[float, float, float], y: float, z: float) -> Any:
        return made.CubePrimitive(pose=pose(y=y, z=z), size=made.Vector3(x=size[0], y=size[1], z=size[2]), color=metal)

    def round_one(place: Any, width: float, length: float, bottom: float, top: float, colour: Any) -> Any:
        size = made.Vector3(x=width, y=width, z=length)
        return made.CylinderPrimitive(pose=place, size=size, bottom_scale=bottom, top_scale=top, color=colour)

    def entity(frame: str, **parts: Any) -> Any:
        return made.SceneEntity(timestamp=stamp, frame_id=frame, id=frame, frame_locked=True, **parts)

    yoke = [
        cube((0.2, 1.24, 0.12), 0.0, -0.73),
        cube((0.2, 0.12, 0.77), 0.56, -0.285),
        cube((0.2, 0.12, 0.77), -0.56, -0.285),
    ]
    return made.SceneUpdate(
        entities=[
            entity("base", cylinders=[round_one(pose(z=-0.95), 1.2, 0.3, 1.0, 0.4, metal)]),
            entity(axes[0], cubes=yoke),
            entity(
                axes[1],
                cylinders=[round_one(pose(looks.sign * 0.23, turn=lying), 0.92, 0.2, 0.1, 1.0, dish)],
                arrows=[boresight(0.12, 0.44, 0.92)],
            ),
            entity(f"{axes[1]}_reference", arrows=[boresight(0.82, 0.38, 0.24)]),
        ]
    )
