"""MAVLink: the antenna as a gimbal of MAVLink's gimbal protocol v2, for autopilots and ground stations.

`Gimbal` is the protocol, from message to message and without a clock or a link of its own; `serve` runs it between a
MAVLink link and the operator's socket of a daemon. The daemon knows nothing of it: what is asked over MAVLink is asked
with a lease and meets the same checks as any client's requests.
"""

from gimbal_hil.realtime.mavlink.angles import direction_rad, quaternion
from gimbal_hil.realtime.mavlink.bridge import open_link, reach_of, serve
from gimbal_hil.realtime.mavlink.gimbal import Gimbal, Taken
from gimbal_hil.realtime.mavlink.values import NOT_TOLD, Reach, Seen, Wish, seen_in

__all__ = [
    "NOT_TOLD",
    "Gimbal",
    "Reach",
    "Seen",
    "Taken",
    "Wish",
    "direction_rad",
    "open_link",
    "quaternion",
    "reach_of",
    "seen_in",
    "serve",
]
