"""The one report of an improvement: the gap round by round, experiments and why, what the model gained, what is
left.
"""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from itertools import cycle
from typing import TYPE_CHECKING

from gimbal_hil.knowledge.discrepancy import LEAST_GAP, headline, is_brief
from gimbal_hil.knowledge.improvement.choosing import WORTH
from gimbal_hil.knowledge.improvement.journal import (
    Chosen,
    Diagnosed,
    Ended,
    Entry,
    Measured,
    Measuring,
    Refused,
    Resumed,
    Stopped,
)
from gimbal_hil.knowledge.improvement.motion import MADE
from gimbal_hil.knowledge.improvement.task import Ending, leaves_unjudged
from gimbal_hil.pages.report import (
    Block,
    Callout,
    Details,
    Heading,
    Listing,
    Page,
    Plot,
    Table,
    Text,
    Tiles,
    counted,
    quantity,
)
from sim_backend.model import AntennaModel, load_model

if TYPE_CHECKING:
    from gimbal_hil.knowledge.improvement.task import Task
    from gimbal_hil.pages.plots import Drawing

_GAP_CAPTION = (
    "Rms that is left of each channel. Each round begins (filled) with the model that its search starts from, on data "
    "that had no part in making it, and ends (open) with what the diagnosis proposes. Below the dashed line a channel "
    "counts as explained."
)


def improvement_page(task: Task, entries: Sequence[Entry]) -> Page:
    """The page for a journal, whether the improvement ended or was stopped."""
    rounds = list({e.round: e for e in entries if isinstance(e, Diagnosed)}.values())
    measured = [e for e in entries if isinstance(e, Measured)]
    end = next((e for e in reversed(entries) if isinstance(e, Ended | Stopped)), None)
    model = _last_model(task, rounds)
    used_s = max((e.antenna_s for e in measured), default=0.0)
    blocks: list[Block] = [_conclusion(end, rounds), _tiles(task, rounds, measured, used_s, end)]
    if rounds:
        blocks += [Heading("The gap, round by round"), Plot(_gap_figure(rounds), _GAP_CAPTION), _round_table(rounds)]
    blocks += [Heading("Experiments"), _experiment_table(entries), *_menu(rounds)]
    blocks += [Heading("What the model gained"), *_gained(task.start, model, rounds)]
    if rounds:
        blocks += [Heading("What is left"), *_left(rounds[-1], end)]
    blocks += [Heading("Budgets"), _budget_table(task, entries, used_s, len(rounds))]
    blocks += [
        Details("Log", [Listing("\n".join(_line(entry) for entry in entries), "One line an entry of journal.jsonl.")])
    ]
    return Page(
        "Improving the model on the antenna itself",
        f"Start: {task.start.name}; {counted(len(measured), 'experiment')}",
        blocks,
    )


def _last_model(task: Task, rounds: Sequence[Diagnosed]) -> AntennaModel:
    place = next((one.model for one in reversed(rounds) if one.model is not None), None)
    return task.start if place is None else load_model(task.out / place)


def _conclusion(end: Ended | Stopped | None, rounds: Sequence[Diagnosed]) -> Callout:
    if isinstance(end, Ended):
        taken = next((one for one in reversed(rounds) if one.model is not None and one.effects), None)
        effects = () if taken is None else taken.effects
        added = "\n".join(f"{headline(effect, is_brief(len(effects)))}." for effect in effects)
        at_the_floor = end.ending == Ending.AT_THE_FLOOR.word
        tone = "good" if at_the_floor and not (rounds and leaves_unjudged(rounds[-1])) else "warning"
        if added and tone == "good":
            return Callout(added, tone, f"{end.text} {end.more}".strip())
        return Callout(end.text, tone, end.more)
    return Callout(
        f"Stopped before its end: {end.reason if end else 'the log goes no further'}. --resume goes on from here.",
        "warning",
    )


def _tiles(
    task: Task, rounds: Sequence[Diagnosed], measured: Sequence[Measured], used_s: float, end: Ended | Stopped | None
) -> Tiles:
    items = [(end.ending.replace("_", " ") if isinstance(end, Ended) else "stopped", "ending")]
    if rounds:
        items.append(
            (f"{_worst(rounds[0]):.3g} → {_last_gap(rounds, end):.3g}", "largest gap in floors, first to last")
        )
    items += [
        (f"{len(measured)} in {counted(max(1, len(rounds)), 'round')}", "experiments"),
        (f"{used_s:.0f} s", f"of {task.budgets.antenna_s:.0f} s antenna time"),
    ]
    return Tiles(tuple(items))


def _worst(one: Diagnosed, key: str = "before") -> float:
    return max((gap[key] / gap["noise_floor"] for gap in one.gaps), default=0.0)


def _last_gap(rounds: Sequence[Diagnosed], end: Ended | Stopped | None) -> float:
    """What the last model leaves: as measured where it was checked, else as its diagnosis says."""
    checked = isinstance(end, Ended) and end.ending == Ending.AT_THE_FLOOR.word
    return _worst(rounds[-1], "before" if checked else "after")


def _gap_figure(rounds: Sequence[Diagnosed]) -> Drawing:
    from gimbal_hil.pages.plots import ALERT, MEASURED, MODEL, REFERENCE, SECOND, figure, in_floors

    drawn = figure("Left over, in noise floors", "round", "rms / noise floor", 380)
    channels = dict.fromkeys((gap["axis"], gap["signal"]) for one in rounds for gap in one.gaps)
    shades = {"torque": [MEASURED, MODEL], "rate_error": [SECOND, REFERENCE]}
    colours = {channel: shades[channel[1]].pop(0) for channel in channels if shades.get(channel[1])}
    for channel, shape in zip(channels, cycle(("circle", "square", "diamond", "triangle-up")), strict=False):
        x: list[float | None] = []
        y: list[float | None] = []
        symbols: list[str] = []
        for one in rounds:
            for gap in one.gaps:
                if (gap["axis"], gap["signal"]) == channel:
                    # a gap between rounds: a search may begin from the first model again
                    x += [one.round - 0.12, one.round + 0.12, None]
                    y += [gap["before"] / gap["noise_floor"], gap["after"] / gap["noise_floor"], None]
                    symbols += [shape, f"{shape}-open", shape]
        drawn.add_scatter(
            x=x, y=y, mode="lines+markers", name=f"{channel[0]} {channel[1].replace('_', ' ')}",
            line=dict(color=colours.get(channel), width=1.5), marker=dict(symbol=symbols, size=9),
        )  # fmt: skip
    sizes = [size for trace in drawn.data for size in trace["y"] if size is not None]
    drawn.add_hline(y=LEAST_GAP, color=ALERT, width=1, dash="dash")
    in_floors(drawn, [*sizes, LEAST_GAP])
    drawn.update_xaxes(tickvals=[one.round for one in rounds], range=[rounds[0].round - 0.5, rounds[-1].round + 0.5])
    drawn.update_layout(hovermode="closest")
    return drawn


def _round_table(rounds: Sequence[Diagnosed]) -> Table:
    rows = []
    for one in rounds:
        named = "; ".join(f"{e['name'].replace('_', ' ')} on {e['axis']}" for e in one.effects) or "–"
        gaps = f"{_worst(one):.2f} → {_worst(one, 'after'):.2f}"
        rows.append((str(one.round), one.verdict.replace("_", " "), named, gaps, one.decision, f"{one.wall_s:.0f}"))
    header = ("round", "verdict", "named", "largest gap [floors]", "decision", "diagnosis [s]")
    return Table(header, rows, "Largest gap of any channel, before and after what the diagnosis proposes.")


def _experiment_table(entries: Sequence[Entry]) -> Table:
    chosen = {e.run: e for e in entries if isinstance(e, Chosen)}
    rehearsed = {e.run: e for e in entries if isinstance(e, Measuring)}
    done = {e.run: e for e in entries if isinstance(e, Measured)}
    rows = []
    for run, choice in chosen.items():
        plan = rehearsed.get(run)
        torque = "" if plan is None else ", ".join(f"{axis} {torque:.2f}" for axis, torque in plan.torque_nm.items())
        state = f"{plan.duration_s:.0f}" if plan is not None and run in done else "not complete"
        rows.append((str(choice.round), choice.sequence, " and ".join(choice.axes), choice.why, torque, state))
    for refused in (e for e in entries if isinstance(e, Refused)):
        rows.append((str(refused.round), refused.sequence, "", f"refused: {refused.reason}", "", ""))
    header = ("round", "experiment", "axes", "why", "peak torque [N m]", "duration [s]")
    return Table(
        header, rows, "In the order in which they were run; torque as rehearsed on the model before anything moved."
    )


def _menu(rounds: Sequence[Diagnosed]) -> list[Block]:
    rows = []
    for one in rounds:
        for entry in one.considered:
            run = (
                one.choice is not None
                and entry["sequence"] == one.choice["sequence"]
                and entry["axis"] in one.choice["axes"]
            )
            rows.append(
                (
                    str(one.round),
                    f"{entry['sequence']} on {entry['axis']}",
                    f"{entry['expected']:,.0f}",
                    # journals of before motions were made have none
                    f"{entry['seconds']:.0f}" if "seconds" in entry else "",
                    "run" if run else "",
                )
            )
    if not rows:
        return []
    caption = (
        "The menu as it was weighed: squared floors that the other explanation, or the model without a cause that no "
        "hold-out has shown, "
        "would leave beyond the best one, refitted as far as the data so far allow. Nothing is run for less than "
        f"{WORTH:g}. A motion that was made for the question ({MADE}) is told where a second of antenna time tells "
        "more than with every entry."
    )
    return [Table(("round", "entry of the menu", "expected difference", "seconds", ""), rows, caption)]


def _gained(start: AntennaModel, model: AntennaModel, rounds: Sequence[Diagnosed]) -> list[Block]:
    blocks: list[Block] = []
    # what a later round found again stands as it was found last
    last = {(e["name"], e["axis"]): (one, e) for one in rounds if one.model is not None for e in one.effects}
    rows = [
        (
            f"{e['name'].replace('_', ' ')} on {e['axis']}",
            str(one.round),
            e["status"].replace("_", " "),
            name.replace("_", " "),
            f"{p['value']:.4g} {p['unit']}",
            f"{p['low']:.4g} to {p['high']:.4g}",
        )
        for one, e in last.values()
        for name, p in e["parameters"].items()
    ]
    if rows:
        blocks.append(
            Table(
                ("effect", "round", "status", "parameter", "value", "interval"),
                rows,
                "Effects as they were taken over, each in the last round that found it.",
            )
        )
    before, after = start.to_yaml().splitlines(), model.to_yaml().splitlines()
    change = "\n".join(difflib.unified_diff(before, after, "start", "model.yaml", lineterm="", n=1))
    blocks.append(
        Details("Every line of the model file that changed", [Listing(change, "The first model and the last.")])
        if change
        else Text("The model is as it was.")
    )
    return blocks


def _left(last: Diagnosed, end: Ended | Stopped | None) -> list[Block]:
    rows = []
    for gap in last.gaps:
        before, after = gap["before"] / gap["noise_floor"], gap["after"] / gap["noise_floor"]
        channel = f"{gap['axis']} {gap['signal'].replace('_', ' ')}"
        rows.append((channel, quantity(gap["noise_floor"], gap["unit"]), f"{before:.2f}", f"{after:.2f}"))
    header = ("channel", "noise floor", "before [floors]", "after [floors]")
    blocks: list[Block] = [Table(header, rows, f"Round {last.round}, on data that no part of the search used.")]
    if not (isinstance(end, Ended) and end.ending == Ending.AT_THE_FLOOR.word):
        blocks.append(Text(f"{last.text} {last.more}".strip()))
    if last.remark:
        blocks.append(Callout(last.remark, "warning"))
    if last.alternatives:
        also = [(a["name"], a["axis"], a["instead_of"], a["reason"]) for a in last.alternatives]
        blocks.append(Table(("could also be", "axis", "instead of", "why"), also))
    return blocks


def _budget_table(task: Task, entries: Sequence[Entry], used_s: float, rounds: int) -> Table:
    plans = [e for e in entries if isinstance(e, Measuring)]
    rows = [
        ("antenna time", f"{used_s:.0f} s", f"{task.budgets.antenna_s:.0f} s"),
        ("rounds", str(rounds), str(task.budgets.rounds)),
    ]
    for axis in task.budgets.torque_nm:
        peak = max((p.torque_nm[axis] for p in plans), default=0.0)
        low, high = (
            min((p.travel_rad[axis][0] for p in plans), default=0.0),
            max((p.travel_rad[axis][1] for p in plans), default=0.0),
        )
        least, most = task.budgets.travel_rad[axis]
        rows.append((f"torque, {axis}", f"{peak:.2f} N m", f"{task.budgets.torque_nm[axis]:g} N m"))
        rows.append((f"travel, {axis}", f"{low:+.2f} to {high:+.2f} rad", f"{least:+.2f} to {most:+.2f} rad"))
    return Table(
        ("budget", "used", "allowed"),
        rows,
        "Torque and travel as rehearsed; guards hold the antenna to what is allowed.",
    )


def _line(entry: Entry) -> str:
    match entry:
        case Chosen():
            return f"round {entry.round}  chosen      {entry.run}: {entry.why}"
        case Refused():
            return f"round {entry.round}  refused     {entry.sequence}: {entry.reason}"
        case Measuring():
            return f"round {entry.round}  measuring   {entry.run}: {entry.duration_s:.0f} s"
        case Measured():
            return f"round {entry.round}  measured    {entry.run}: {entry.antenna_s:.0f} s used in all"
        case Diagnosed():
            return f"round {entry.round}  diagnosed   {entry.verdict}: {entry.decision}"
        case Resumed():
            return f"         resumed     after {entry.lines_before} lines"
        case Stopped():
            return f"         stopped     {entry.reason}"
        case Ended():
            return f"         ended       {entry.ending}: {entry.text} {entry.more}".rstrip()
        case _:
            return "         started"
