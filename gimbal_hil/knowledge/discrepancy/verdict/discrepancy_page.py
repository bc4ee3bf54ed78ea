"""The report: what was found in plain words, where the gap sits, the ranking, before and after, and what the model file
gained.
"""

from __future__ import annotations

import difflib

from firmware_protocol.json_object import Json
from gimbal_hil.knowledge.discrepancy.inquiry import LEAST_GAP, gain_on
from gimbal_hil.knowledge.discrepancy.judgement import Result
from gimbal_hil.knowledge.discrepancy.verdict.gaps import Gap, share_text, still_open
from gimbal_hil.knowledge.discrepancy.verdict.page_figures import (
    explained,
    gap_figure,
    law_figure,
    over_figure,
    time_figure,
    where_figure,
)
from gimbal_hil.knowledge.discrepancy.verdict.shown_table import smallest_shown
from gimbal_hil.knowledge.discrepancy.verdict.verdict import Verdict, entries_of
from gimbal_hil.knowledge.discrepancy.verdict.wording import told_contradictions
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
    from_to,
    quantity,
)
from sim_backend.model import ActsOn, AntennaModel

_GAP_CAPTION = (
    "Rms that is left of each channel {}, with the model as given and with what is told. The processing floor, where "
    "there is one, is the error of the method itself. Every analysis reads the noise floor anew; it depends on its "
    "logs and their roles (here from: {}), its band (here up to {:.3g} Hz) and the model's inertia, which makes torque "
    "of encoder steps, so the floors of two analyses may differ."
)
_TONE = {
    "named": "good",
    "no_discrepancy": "good",
    "cannot_judge": "warning",
    "ambiguous": "warning",
    "unexplained": "warning",
    "described": "warning",
}


def discrepancy_page(result: Result, found: Verdict, corrected: AntennaModel | None, sources: list[str]) -> Page:
    """The page for one result."""
    verdict, told = found.document, found.told_gap
    assert told is not None, "a verdict on refused logs has no page"
    blocks = _answer(result, found, told)
    if verdict["effects"]:
        blocks += [Heading("What was found"), _effects_table(result, verdict)]
    if result.described is not None:
        blocks += _looks_like(result)
    if verdict["alternatives"]:
        blocks += [Heading("What it could also be"), _alternatives(verdict)]
    if found.where:
        blocks += [
            Heading("Where it sits"),
            Plot(
                where_figure(result, told),
                "Share of the squared gap with 90 % block-bootstrap intervals; red marks are the share of time. Every "
                "group cuts the same data in another way: within one group the bars add up to 1.",
            ),
        ]
    rivals = _rivals(result)
    blocks += [Heading("What was tried"), _ranking(result), *([rivals] if rivals else [])]
    blocks += [
        Heading("Before and after"),
        Plot(
            time_figure(result),
            f"Left over {_judged_on(result)}, before and, where something explains it, after; lines: the noise floor.",
        ),
    ]
    if corrected is not None:
        change = "\n".join(
            difflib.unified_diff(
                result.model.to_yaml().splitlines(),
                corrected.to_yaml().splitlines(),
                "model",
                "corrected",
                lineterm="",
                n=2,
            )
        )
        blocks += [
            Heading("What the model file gained"),
            Listing(change, "Difference between the input model and model.yaml."),
        ]
    if verdict["recalibrated"]:
        heads = ("axis", "number", "model", "known to", "refitted", "interval", "moved by, of what it is known to")
        rows = [_moved_row(moved) for moved in verdict["recalibrated"]]
        blocks.append(Details("Known numbers that had to move", [Table(heads, rows)]))
    blocks += smallest_shown(verdict["smallest_shown"], "errors")
    if verdict["not_testable"]:
        unseen = [(n["name"], n["axis"], n["reason"]) for n in verdict["not_testable"]]
        blocks.append(Details("What this data cannot show", [Table(("effect", "axis", "reason"), unseen)]))
    notes = [note for record in (*result.inquiry.twin.records,) for note in ([record.source] if record.source else [])]
    blocks.append(Details("Data", [Text("; ".join(sources)), *([Text("; ".join(notes))] if notes else [])]))
    return Page(
        "What the model is missing",
        f"Model {result.model.name}; verdict: {verdict['verdict'].replace('_', ' ')}",
        blocks,
    )


def _answer(result: Result, found: Verdict, gap: Gap) -> list[Block]:
    """What a reader came for: the sentence, the figures, how large the gap is, and the plot that shows its kind."""
    verdict, planned = found.document, found.next_experiment
    against = " ".join(told_contradictions(found.contradictions))
    return [
        _said(found),
        *([Callout(f"Run this next: {planned['plan']}.\n{planned.get('command', '')}".strip())] if planned else []),
        *([Callout(against, "warning")] if against else []),
        Tiles([(verdict["verdict"].replace("_", " "), "verdict"), *_gap_tiles(result, found, gap), _floor_tile(gap)]),
        Heading("How large the gap is"),
        Plot(gap_figure(verdict), _GAP_CAPTION.format(_judged_on(result), gap.noise_floor_from, gap.band_hz[1])),
        *_proof(result, gap),
    ]


def _gap_tiles(result: Result, found: Verdict, gap: Gap) -> list[tuple[str, str]]:
    """How large the gap is in its unit, how much of it is closed, and the largest that is still there."""
    channel, which = _channel(gap), "largest gap" if gap is found.gap else "gap"
    before, after = (gap.before, gap.noise_floor), (gap.after, gap.noise_floor_after)
    if not explained(result):
        told = quantity(gap.before, gap.unit)
        # what is below the limit is no gap
        which = which if gap.before > LEAST_GAP * gap.noise_floor else "left where it is judged"
        return [(told, f"{which}, {channel}: {gap.before / gap.noise_floor:.3g} noise floors")]
    size = from_to(gap.before, gap.after, gap.unit)
    floors = " → ".join(f"{rms / floor:.3g}" for rms, floor in (before, after))
    tiles = [(size, f"{which}, {channel}: {floors} noise floors")]
    if gap.closed_fraction is not None and gap.closed_low is not None and gap.closed_high is not None:
        low, high = share_text(gap.closed_low), share_text(gap.closed_high)
        between = f" ({low} to {high})" if low != high else ""
        tiles.append((share_text(gap.closed_fraction), f"of it closed{between}, {_judged_on(result)}"))
    for one in still_open(found.gaps)[:1]:
        times = f"{one.after / one.noise_floor_after:.3g} noise floors"
        tiles.append((quantity(one.after, one.unit), f"largest gap still unexplained, {_channel(one)}: {times}"))
    return tiles


def _channel(gap: Gap) -> str:
    return f"{gap.signal.replace('_', ' ')} of {gap.axis}"


def _said(found: Verdict) -> Callout:
    """The verdict's own words; contradictions have their own place."""
    said, tone = found.said, _TONE[found.kind.value]
    if tone == "good" and said.left:
        tone = "warning"
    elif tone == "good" and said.moved:
        tone = "neutral"
    return Callout("\n".join(part for part in (said.answer, said.left) if part), tone, said.grounds)


def _looks_like(result: Result) -> list[Block]:
    """Every law with its band, beside what rows of the hold-out say."""
    laws = () if result.described is None else result.described.laws
    caption = (
        "Lines: the law with the band in which other stretches of the logs would have put it, dashed the formula that "
        "says as much; a curve stays outside its knots as it ends. Dots, where they are drawn: the law less what is "
        f"left {_judged_on(result)}. It says what is missing looks like, not what it is."
    )
    # what is left is the command less what the model asks for
    turned = " The command makes up for a torque at the joint, so what is left of it has the other sign."
    plots = [
        Plot(law_figure(result, law), caption + (turned if law.curve.shape.acts_on is ActsOn.TORQUE else ""))
        for law in laws
    ]
    return [Heading("What it looks like"), *plots]


def _floor_tile(gap: Gap) -> tuple[str, str]:
    """The noise floor; a larger inertia makes more of the encoder's error, and what is left is then noise to it."""
    floor, after = (quantity(one, gap.unit) for one in (gap.noise_floor, gap.noise_floor_after))
    of = f"noise floor of the {_channel(gap)}"
    return (
        (floor, of) if floor == after else (f"{floor} → {after}", f"{of}, with the inertia of the model and as fitted")
    )


def _moved_row(moved: Json) -> tuple[str, ...]:
    """A known number that moved, in units of what it is known to: of next to nothing any move is many times it."""
    stated, spread, value = moved["nominal"], moved["uncertainty"], moved["value"]
    share = f"{(value - stated) / spread:+.2f}" if spread > 0.0 else "it was taken as exact"
    interval = f"{moved['low']:.4g} .. {moved['high']:.4g}"
    return moved["axis"], moved["path"], f"{stated:.4g}", f"{spread:.2g}", f"{value:.4g}", interval, share


def _judged_on(result: Result) -> str:
    """What the sizes of the page were measured on."""
    if result.suspected_only:
        return "on the last part of the same log"
    return "on held-out rows that no part of the search used"


def _proof(result: Result, gap: Gap) -> list[Block]:
    """The plot that shows what kind of thing is missing: what is left over position, speed and temperature."""
    caption = (
        f"Dots: rows, {_judged_on(result)}; lines: their mean over what is below each panel. "
        "A wave over position is a ripple, a slope over rate acts with speed, a step at zero rate with direction."
    )
    return [
        Heading(f"What is left of {gap.axis} {gap.signal.replace('_', ' ')}, and over what"),
        Plot(over_figure(result, gap), caption),
    ]


def _effects_table(result: Result, verdict: Json) -> Table:
    rows = []
    for e in verdict["effects"]:
        for name, p in (item for entry in entries_of(e) for item in entry.items()):
            nominal = "" if p["nominal"] is None else f"{p['nominal']:.4g}"
            _, value, interval = _value((name, p))
            rows.append(
                (
                    f"{e['name']} ({e['axis']})",
                    e["status"],
                    name,
                    value,
                    interval,
                    nominal,
                    f"{e['held_out_gain']:.1%}",
                    f"{e['best_control_gain']:.1%}",
                    f"{e['confidence']:.2f}",
                )
            )
    header = ("effect", "status", "parameter", "value", "interval", "model had", "gain", "control", "confidence")
    return Table(
        header,
        rows,
        f"Gain: share of the gap that the effect takes {_judged_on(result)}; control: what its negative control takes.",
    )


def _words(name: str) -> str:
    return name.replace("_", " ")


def _value(parameter: tuple[str, Json]) -> tuple[str, str, str]:
    """Name, value with unit and interval of a number."""
    name, p = parameter
    unit = "" if p["unit"] == "1" else p["unit"]
    return name, f"{p['value']:.4g} {unit}".rstrip(), f"{p['low']:.4g} .. {p['high']:.4g}"


def _alternatives(verdict: Json) -> Table:
    rows = []
    for one in verdict["alternatives"]:
        told = [
            f"{_words(name)} {value} ({interval})" for name, value, interval in map(_value, one["parameters"].items())
        ]
        row = (_words(one["name"]), one["axis"], _words(one["instead_of"]), "; ".join(told))
        rows.append((*row, f"{one['probability']:.2f}", one["reason"]))
    return Table(("could also be", "axis", "instead of", "its numbers there", "probability", "why"), rows)


def _ranking(result: Result) -> Table:
    rows = []
    for number, one in enumerate(result.path.rounds, start=1):
        for tried in one.tried[:6]:
            effect, axis = tried.hypothesis.labels[-1]
            fitted, held = (gain_on(result.inquiry, one.before, tried, part) for part in ("fitted", "selecting"))
            control = one.controls.get((effect, axis))
            rows.append(
                (
                    str(number),
                    effect.replace("_", " "),
                    axis,
                    f"{fitted.mean:.3f}",
                    f"{fitted.sure:.1f}",
                    f"{held.mean:.3f}",
                    f"{held.sure:.1f}",
                    "" if control is None else f"{control:.3f}",
                )
            )
    judging = "last part" if result.suspected_only else "hold-out"
    errors = "in standard errors"
    header = ("round", "candidate", "axis", "takes, fitted", errors, f"takes, {judging}", errors, "its control takes")
    return Table(
        header,
        rows,
        "What a candidate takes, in mean squares of what was left before it, on what is fitted and on the part of the "
        f"{'log' if result.suspected_only else 'hold-out'} that selects, and how many of its standard errors over "
        "blocks that is. A control is the candidate's own response, scrambled in time.",
    )


def _more_left(extra: float) -> str:
    """By how much more a rival leaves: in percent, and in times where percent have too many digits."""
    return f"{1.0 + extra:,.0f} times" if extra > 10.0 else f"{extra:+.1%}"


def _rivals(result: Result) -> Table | None:
    """What was put in the place of each cause; None where nothing was."""
    rows = []
    policy = result.inquiry.policy
    for one in result.told:
        name = f"{one.standing.label[0]} ({one.standing.label[1]})"
        for rival in one.standing.rivals[:4]:
            apart = "no" if rival.close(policy) else "yes"
            other = " and ".join(f"{effect} ({axis})" for effect, axis in rival.labels)
            row = tuple(cell.replace("_", " ") for cell in (name, other))
            rows.append((*row, f"{rival.sure:.1f}", _more_left(rival.extra), apart))
    caption = (
        "What could stand in the place of a cause, refitted there: by how many standard errors over blocks it explains "
        "less, and how much it leaves beside what the cause leaves. They cannot be told apart under "
        f"{policy.sure:g} ({policy.anew:g} for another order of the same ripple), or by less than a model is exact to "
        f"({policy.same:.0%} of what is left or of the rms that the "
        f"cause takes, {policy.least_squares:g} squared noise floors) or than the part of what is left that can be "
        "predicted, since something else is missing there."
    )
    return (
        Table(
            ("cause", "in its place", "standard errors", "squares left", "told apart"),
            list(dict.fromkeys(rows)),
            caption,
        )
        if rows
        else None
    )
