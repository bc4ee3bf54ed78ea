"""Speed figures, each beside a plain reference from the same run, as a ratio with its spread."""

from gimbal_hil.proof.bench.blind import BlindChoice, run_blind
from gimbal_hil.proof.bench.figures import Figure, Goal, GoalKind, paired
from gimbal_hil.proof.bench.history import HISTORY_FILE, remember
from gimbal_hil.proof.bench.real_time import real_time_figures
from gimbal_hil.proof.bench.real_time_page import real_time_blocks, real_time_text
from gimbal_hil.proof.bench.results import bench_page, bench_text, slower_blocks, speed_blocks
from gimbal_hil.proof.bench.search import search_figures
from gimbal_hil.proof.bench.search_page import search_blocks, search_text
from gimbal_hil.proof.bench.soak import SoakFigures, soak, soak_text
from gimbal_hil.proof.bench.soak_across import AcrossFigures, across_text, soak_across
from gimbal_hil.proof.bench.soak_page import soak_blocks
from gimbal_hil.proof.bench.speed import ask_for_kernels, speed_figures

__all__ = [
    "HISTORY_FILE",
    "AcrossFigures",
    "BlindChoice",
    "Figure",
    "Goal",
    "GoalKind",
    "SoakFigures",
    "across_text",
    "ask_for_kernels",
    "bench_page",
    "bench_text",
    "paired",
    "real_time_blocks",
    "real_time_figures",
    "real_time_text",
    "remember",
    "run_blind",
    "search_blocks",
    "search_figures",
    "search_text",
    "slower_blocks",
    "soak",
    "soak_across",
    "soak_blocks",
    "soak_text",
    "speed_blocks",
    "speed_figures",
]
