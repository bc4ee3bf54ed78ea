"""Comparison of controllers: scenarios x antennas x controllers x seeds, judged by the true line of sight."""

from gimbal_hil.pointing.arena.arena import ArenaResult, Entrant, Spread, entrants, run_arena
from gimbal_hil.pointing.arena.base_motions import ROW_HZ as MOTION_ROW_HZ
from gimbal_hil.pointing.arena.base_motions import AircraftMotion, Manoeuvre, Swing, Turbulence, write_motion
from gimbal_hil.pointing.arena.controllers import CONTROLLERS, LAWS, available, controller_settings, least_margin_on
from gimbal_hil.pointing.arena.gained import gained_blocks, gained_text, what_tuning_gave
from gimbal_hil.pointing.arena.page import arena_blocks, arena_text
from gimbal_hil.pointing.arena.paid import (
    BEFORE,
    FIRST,
    IMPROVED,
    Paid,
    changed_parts,
    paid_blocks,
    paid_text,
    what_paid,
)
from gimbal_hil.pointing.arena.scenarios import Scenario, Score, chosen, load_scenarios, shipped_scenarios
from gimbal_hil.pointing.arena.trial import Trial, TrialOutcome, between, boresight, run_trial
from gimbal_hil.pointing.arena.wrong_numbers import with_wrong_model, wrong_model

__all__ = [
    "BEFORE",
    "CONTROLLERS",
    "FIRST",
    "IMPROVED",
    "LAWS",
    "MOTION_ROW_HZ",
    "AircraftMotion",
    "ArenaResult",
    "Entrant",
    "Manoeuvre",
    "Paid",
    "Scenario",
    "Score",
    "Spread",
    "Swing",
    "Trial",
    "TrialOutcome",
    "Turbulence",
    "arena_blocks",
    "arena_text",
    "available",
    "between",
    "boresight",
    "changed_parts",
    "chosen",
    "controller_settings",
    "entrants",
    "gained_blocks",
    "gained_text",
    "least_margin_on",
    "load_scenarios",
    "paid_blocks",
    "paid_text",
    "run_arena",
    "run_trial",
    "shipped_scenarios",
    "what_paid",
    "what_tuning_gave",
    "with_wrong_model",
    "write_motion",
    "wrong_model",
]
