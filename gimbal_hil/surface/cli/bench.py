"""`gimbal-hil bench`: speed, real time and the search's cost as ratios, the fault matrix, the soak, the arena of
controllers, or the blind bench of the discrepancy search.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NoReturn

import typer

from firmware_protocol.places import require_new
from gimbal_hil.surface.cli.bench_findings import BenchFindings
from gimbal_hil.surface.cli.following import closer_to_faults, closer_to_soak, closer_to_speed

BENCHES = ("speed", "realtime", "search", "blind", "faults", "soak", "pointing")


@dataclass(frozen=True)
class BenchOptions:
    """What several benches take, or one that has no more; each option says whose it is."""

    repeats: Annotated[int, typer.Option(help="speed, search: pairs per figure.", min=3)] = 9
    out: Annotated[Path | None, typer.Option(help="Folder for the results page and its history.")] = None
    force: Annotated[bool, typer.Option("--force", help="Overwrite what is in the folder.")] = False
    as_json: Annotated[bool, typer.Option("--json", help="Print the figures as JSON.")] = False
    link: Annotated[
        list[str] | None,
        typer.Option(
            help="realtime: unix, serial or slcan; may be repeated. soak: on this link in real time, across processes. "
            "faults: whose firmware, virtual, c, cortex-m or qemu."
        ),
    ] = None
    rate: Annotated[list[float] | None, typer.Option(help="realtime: Hz; may be repeated.", min=1.0)] = None
    seconds: Annotated[float, typer.Option(help="realtime: for each link and rate.", min=1.0)] = 60.0
    seed: Annotated[
        int | None, typer.Option(help="blind: a fresh bench; without it the folder's, or the training set's (0).")
    ] = None
    every: Annotated[int, typer.Option(help="faults: take every n-th row only.", min=1)] = 1
    hours: Annotated[float, typer.Option(help="soak: antenna time.", min=0.001)] = 24.0
    workers: Annotated[int, typer.Option(help="search, blind, pointing: processes (blind: a case in each).", min=1)] = 2

    @property
    def page(self) -> Path | None:
        """Where the report goes."""
        return None if self.out is None else self.out / "report.html"


@dataclass(frozen=True)
class BlindOptions:
    """What the blind bench takes besides."""

    sealed: Annotated[
        str | None, typer.Option(metavar="RELEASE", help="blind: the seed that belongs to a tag's commit.")
    ] = None
    kinds: Annotated[str | None, typer.Option(help="blind: only these kinds of cases, comma between.")] = None
    cases: Annotated[
        str | None, typer.Option(metavar="PATTERN", help="blind: only cases of such names, as 'single.cogging.*'.")
    ] = None
    most: Annotated[int | None, typer.Option(help="blind: at most so many cases of a kind.", min=1)] = None
    first: Annotated[int | None, typer.Option(help="blind: so many cases in all.", min=1)] = None
    keep: Annotated[str, typer.Option(help="blind: whose logs and reports stay on disk: wrong, all, none.")] = "wrong"
    table: Annotated[bool, typer.Option("--table", help="blind: only print the tables of what has been judged.")] = (
        False
    )
    compare: Annotated[
        Path | None, typer.Option(metavar="OLD", help="blind: only say what differs from the results in this folder.")
    ] = None
    dask: Annotated[str | None, typer.Option(metavar="ADDRESS", help="blind: diagnose on a Dask cluster instead.")] = (
        None
    )


@dataclass(frozen=True)
class ArenaOptions:
    """What the arena of controllers takes besides."""

    controller: Annotated[
        list[str] | None, typer.Option(help="pointing: by name, or a configuration file; may be repeated.")
    ] = None
    antenna: Annotated[list[str] | None, typer.Option(help="pointing: a model by name or file; repeatable.")] = None
    scenario: Annotated[list[str] | None, typer.Option(help="pointing: words of names, or a file; repeatable.")] = None
    seeds: Annotated[int, typer.Option(help="pointing: runs of each, noise and turbulence anew.", min=1)] = 3
    wrong: Annotated[float, typer.Option(help="pointing: share that models are off by.", min=0.0, max=0.9)] = 0.0


def command(
    what: Annotated[
        str,
        typer.Argument(help="speed, realtime, search, faults, soak, pointing, or blind (needs the source checkout)."),
    ] = "speed",
    *,
    options: BenchOptions,
    blind: BlindOptions,
    arena: ArenaOptions,
) -> int:
    """Figures of this machine and of the methods: speed beside a plain reference, deadlines, faults, controllers.

    Each option says which of them it belongs to.
    """
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.surface.cli.bench_pointing import ArenaChoice, pointing

    if what not in BENCHES:
        raise BadInputError("bench", f"no bench {what!r}", ", ".join(BENCHES))
    if what == "blind":
        _blind(options, blind)
    if options.out is not None:
        require_new(options.out, options.force, "report.html")
    choice = ArenaChoice(
        arena.controller or [], arena.antenna or [], arena.scenario or [], arena.seeds, options.workers, arena.wrong
    )
    measured = pointing(choice) if what == "pointing" else _MEASURING[what](options)
    return _answer(what, measured, options)


def _answer(what: str, measured: BenchFindings, options: BenchOptions) -> int:
    import json
    import sys

    from gimbal_hil.surface.cli.following import after_bench
    from gimbal_hil.surface.cli.next_line import print_next

    words, text, figures, blocks, costs, config, closer = measured
    page, as_json = options.page, options.as_json
    print(json.dumps(figures) if as_json else text, flush=True)
    # what the search costs has no target: it is a table of costs
    all_right = what == "search" or not any(figure["problem"] for figure in figures)
    if page is not None:
        from gimbal_hil.proof.bench import HISTORY_FILE, bench_page, remember, slower_blocks

        slower = remember(page.parent / HISTORY_FILE, what, costs) if costs else []
        for line in slower:
            print(f"SLOWER {line}", file=sys.stderr, flush=True)
        bench_page([*slower_blocks(slower), *blocks], f"gimbal-hil bench {words}").write(page)
    if not as_json:
        if page is not None:
            print(f"\nreport: {page}")
        print_next(after_bench(not all_right, closer, config))
    return 0 if all_right else 1


def _measuring(name: str) -> None:
    import sys

    print(f"measuring {name} ...", file=sys.stderr, flush=True)


def _blind(options: BenchOptions, blind: BlindOptions) -> NoReturn:
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.proof.bench import BlindChoice, run_blind

    if options.out is None:
        raise BadInputError("--out", "is missing", "a folder for the blind cases and their verdicts")
    given = vars(blind) | {"kinds": tuple(blind.kinds.split(",")) if blind.kinds else ()}
    run_blind(BlindChoice(options.out, options.seed, workers=options.workers, **given))


def _faults(options: BenchOptions) -> BenchFindings:
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.loop.settings import shipped_settings
    from gimbal_hil.proof.bench.faults import fault_rows, matrix_blocks, matrix_text, run_matrix
    from sim_backend.firmware_run import FirmwareRun
    from sim_backend.model import shipped_model

    every, link = options.every, options.link[0] if options.link else "virtual"
    firmware = next((run for run in FirmwareRun if run.value == link), None)
    if firmware is None:
        raise BadInputError("--link", f"{link!r} is no firmware", ", ".join(FirmwareRun))
    found = run_matrix(fault_rows()[::every], shipped_settings(), shipped_model(), _measuring, firmware)
    words = "faults" + (f" --every {every}" if every > 1 else "") + (f" --link {link}" if link != "virtual" else "")
    figures = [one.as_dict() for one in found]
    return BenchFindings(words, matrix_text(found), figures, matrix_blocks(found), closer=closer_to_faults(link))


def _soak_across(link: str, hours: float, seed: int) -> BenchFindings:
    from dataclasses import asdict

    from gimbal_hil.proof.bench import across_text, soak_across, soak_blocks

    found = soak_across(link, hours, seed, _measuring)
    text = across_text(found)
    figures = [{**asdict(found), "problem": "; ".join(found.problems)}]
    blocks = soak_blocks(text, found.problems)
    words = f"soak --hours {hours:g} --link {link}"
    return BenchFindings(words, text, figures, blocks, closer=closer_to_soak(link))


def _soak(options: BenchOptions) -> BenchFindings:
    from dataclasses import asdict

    from gimbal_hil.loop.settings import shipped_settings
    from gimbal_hil.proof.bench import soak, soak_blocks, soak_text
    from sim_backend.model import shipped_model

    hours, seed = options.hours, options.seed or 0
    if options.link:
        return _soak_across(options.link[0], hours, seed)
    found = soak(shipped_settings(), shipped_model(), hours, seed, _measuring)
    text = soak_text(found)
    figures = [{**asdict(found), "problem": "; ".join(found.problems)}]
    blocks = soak_blocks(text, found.problems)
    return BenchFindings(f"soak --hours {hours:g}", text, figures, blocks, closer=closer_to_soak(None))


def _speed(options: BenchOptions) -> BenchFindings:
    from dataclasses import asdict

    from gimbal_hil.proof.bench import bench_text, speed_blocks, speed_figures

    repeats = options.repeats
    figures = speed_figures(repeats, _measuring)
    rows = [asdict(one) | {"problem": one.problem} for one in figures]
    costs = {f"{one.name}, beside {one.reference}": one.cost for one in figures}
    closer = closer_to_speed(repeats, options.out)
    return BenchFindings(f"--repeats {repeats}", bench_text(figures), rows, speed_blocks(figures), costs, closer=closer)


def _real_time(options: BenchOptions) -> BenchFindings:
    from gimbal_hil.proof.bench import real_time_blocks, real_time_figures, real_time_text

    links, rates_hz, seconds = options.link or ("unix", "serial"), options.rate or (1e3, 2e3), options.seconds
    found = real_time_figures(tuple(links), tuple(rates_hz), seconds, _measuring)
    figures = [one.as_dict() for one in found]
    return BenchFindings(f"realtime --seconds {seconds:g}", real_time_text(found), figures, real_time_blocks(found))


def _search(options: BenchOptions) -> BenchFindings:
    from dataclasses import asdict

    from gimbal_hil.proof.bench import search_blocks, search_figures, search_text

    workers = options.workers
    found = search_figures(workers, options.repeats, _measuring)
    costs = {f"search on {one.amount:g} s": one.million_sines for one in found.by_length}
    costs |= {f"screening of {one.amount:g} candidates": one.million_sines for one in found.by_candidates}
    return BenchFindings(f"search --workers {workers}", search_text(found), asdict(found), search_blocks(found), costs)


_MEASURING: dict[str, Callable[[BenchOptions], BenchFindings]] = {
    "speed": _speed,
    "realtime": _real_time,
    "search": _search,
    "faults": _faults,
    "soak": _soak,
}
