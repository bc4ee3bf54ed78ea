"""Controllers beside each other: scenarios x antennas x controllers x seeds, judged by where it truly looks."""

from gimbal_hil.arena.arena import ArenaResult, Entrant, Spread, entrants, run_arena
from gimbal_hil.arena.base_motions import Manoeuvre, Swing, Turbulence
from gimbal_hil.arena.controllers import CONTROLLERS, controller_settings
from gimbal_hil.arena.page import arena_blocks, arena_text
from gimbal_hil.arena.scenarios import Scenario, Score, chosen, load_scenarios, shipped_scenarios
from gimbal_hil.arena.trial import Trial, TrialOutcome, between, boresight, run_trial

__all__ = [
    "CONTROLLERS",
    "ArenaResult",
    "Entrant",
    "Manoeuvre",
    "Scenario",
    "Score",
    "Spread",
    "Swing",
    "Trial",
    "TrialOutcome",
    "Turbulence",
    "arena_blocks",
    "arena_text",
    "between",
    "boresight",
    "chosen",
    "controller_settings",
    "entrants",
    "load_scenarios",
    "run_arena",
    "run_trial",
    "shipped_scenarios",
]
