"""`gimbal-hil bench pointing`: controllers beside each other in the arena."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gimbal_hil.surface.cli.bench_findings import BenchFindings
from gimbal_hil.surface.cli.following import closer_to_trip


@dataclass(frozen=True)
class ArenaChoice:
    """What the command line chose of the arena; empty is all."""

    controllers: list[str]
    antennas: list[str]
    #: words of scenarios' names, or files of scenarios
    scenarios: list[str]
    seeds: int
    workers: int
    #: share by which the models of the loops are off
    wrong: float = 0.0

    def words(self) -> str:
        """The choice as words of the command line."""
        words = ["pointing", f"--seeds {self.seeds}"]
        words += [f"--controller {name}" for name in self.controllers]
        words += [f"--antenna {name}" for name in self.antennas]
        words += [f"--wrong {self.wrong:g}"] if self.wrong else []
        return " ".join(words + [f"--scenario '{one}'" for one in self.scenarios])


def pointing(choice: ArenaChoice) -> BenchFindings:
    """Run the arena."""
    from gimbal_hil.pointing.arena import (
        arena_blocks,
        arena_text,
        available,
        chosen,
        entrants,
        load_scenarios,
        run_arena,
        shipped_scenarios,
    )
    from gimbal_hil.surface.cli.progress import ProgressBar
    from sim_backend.model import CONTROL_ANTENNA

    shipped = shipped_scenarios()
    wanted = [
        one
        for words in choice.scenarios or [""]
        for one in (load_scenarios(Path(words)) if words.endswith((".yaml", ".yml")) else chosen(shipped, words))
    ]
    picked = tuple({one.name: one for one in wanted}.values())
    named, antennas = choice.controllers or available(), choice.antennas or ["thesis", CONTROL_ANTENNA]
    who = entrants(named)
    with ProgressBar() as bar:
        bar.begin("arena", len(picked) * len(antennas) * len(who) * choice.seeds, 0.0)
        found = run_arena(
            picked, antennas, who, choice.seeds, choice.workers, lambda done: bar.at(done, 1.0), choice.wrong
        )
    # only the thesis' gains may trip: they are here to be compared with
    figures = [row | {"problem": row["tripped"] if row["controller"] != "thesis" else ""} for row in found.rows()]
    # of the files that were compared the last, which `tune` names last too
    config = next((Path(name) for name in reversed(choice.controllers) if Path(name).is_file()), None)
    tripped = next((row for row in figures if row["problem"]), None)
    # an entrant of a file is called without its folder and ending
    asked = {one.name: word for one, word in zip(who, named, strict=True)}
    closer = tripped and closer_to_trip(
        asked[str(tripped["controller"])], *(str(tripped[key]) for key in ("antenna", "scenario"))
    )
    blocks = arena_blocks(found)
    return BenchFindings(choice.words(), arena_text(found), figures, blocks, config=config, closer=closer or "")
