"""Targets in the sky: their direction from an aircraft, following them, pointing errors and a report."""

from gimbal_hil.pointing.following.base import (
    BASE_S,
    MOTIONS,
    STANDING,
    BaseTruth,
    as_base,
    in_base,
    moved,
    truth_of,
    truth_of_model,
)
from gimbal_hil.pointing.following.clock import TickClock
from gimbal_hil.pointing.following.geodesy import Flight, earth_fixed, flight_of, geostationary, seen_from
from gimbal_hil.pointing.following.in_lockstep import follow_in_lockstep
from gimbal_hil.pointing.following.judging import (
    HeldTrace,
    MuteChange,
    PointingFigures,
    held_trace,
    mute_changes,
    pointing_figures,
)
from gimbal_hil.pointing.following.page import HeldTarget, summary, write_page
from gimbal_hil.pointing.following.reach import joints_needed, reach_of, require_reach
from gimbal_hil.pointing.following.satellite import OLD_DAYS, Elements, read_elements
from gimbal_hil.pointing.following.targets import Target, next_pass, target_of
from gimbal_hil.pointing.following.through_daemon import LEAD_S, FollowedWay, PointingDaemon, stow_moves
from gimbal_hil.pointing.following.way import Way, catmull_rom, joints_seen, way_of

__all__ = [
    "BASE_S",
    "LEAD_S",
    "MOTIONS",
    "OLD_DAYS",
    "STANDING",
    "BaseTruth",
    "Elements",
    "Flight",
    "FollowedWay",
    "HeldTarget",
    "HeldTrace",
    "MuteChange",
    "PointingDaemon",
    "PointingFigures",
    "Target",
    "TickClock",
    "Way",
    "as_base",
    "catmull_rom",
    "earth_fixed",
    "flight_of",
    "follow_in_lockstep",
    "geostationary",
    "held_trace",
    "in_base",
    "joints_needed",
    "joints_seen",
    "moved",
    "mute_changes",
    "next_pass",
    "pointing_figures",
    "reach_of",
    "read_elements",
    "require_reach",
    "seen_from",
    "stow_moves",
    "summary",
    "target_of",
    "truth_of",
    "truth_of_model",
    "way_of",
    "write_page",
]
