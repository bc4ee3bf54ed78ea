"""Is `testable` right? Effects put in at shares of the size that it foresees, and what `discrepancy` makes of them.

    python -m tests.benchmarks.testable_calibration [--out FILE] [--only cogging,viscous] [--axes outer,inner]
        [--seconds 200] [--picture FILE.svg]

The size from which an effect shows is foreseen from a rehearsal of a short survey on the shipped model. Then the effect
is put into the antenna at a half, once and twice that size, two surveys are made, and `discrepancy` is asked: anything
but "nothing is missing" and "cannot judge" counts as shown. Right would be 10, 50 and 95 %. Cases that FILE (.jsonl)
holds are not made again; after `--seconds` no further case is begun.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

from firmware_protocol.errors import BadInputError
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import Kind, Request, diagnose, foreseen
from gimbal_hil.knowledge.discrepancy.foreseen import Shows
from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, survey_motion
from gimbal_hil.knowledge.improvement import rehearse
from gimbal_hil.loop.settings import shipped_settings
from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel, shipped_model

SHARES = (0.5, 1.0, 2.0)
AIMED = (0.10, 0.50, 0.95)
NOTHING = (Kind.NO_DISCREPANCY, Kind.CANNOT_JUDGE)


def survey(model: AntennaModel, number: int, seed: int) -> SignalsTable | None:
    """A short survey of an antenna; None where it is stopped."""
    made = rehearse(survey_motion(SequenceOptions(1000.0, short=True), number), shipped_settings(), model, seed)
    return made.table if made.stopped is None else None


def put_in(model: AntennaModel, one: Shows, share: float) -> AntennaModel:
    """The antenna with an effect at a share of the size from which it is foreseen to show; numbers of it that the
    antenna has and that were not moved stay.
    """
    parameters = CATALOGUE[one.name].parameters
    stay = {p.name: model.number(one.axis, model.number_path(one.axis, p.path)) for p in parameters if p.path}
    values = {name: without + share * (value - without) for name, without, value in one.values}
    return model.with_effect(one.name, one.axis, stay | values)


def outcome(model: AntennaModel, one: Shows, share: float) -> dict[str, Any]:
    """What `discrepancy` makes of two surveys of an antenna with an effect of a share of its size."""
    found: dict[str, Any] = {"name": one.name, "axis": one.axis, "share": share, "size": one.size, "unit": one.unit}
    try:
        antenna = put_in(model, one, share)
        seed = 1 + sum(map(ord, one.name + one.axis))
        tables = [survey(antenna, number, seed + number) for number in (0, 1)]
        if None in tables:
            return found | {"verdict": "stopped"}
        result = diagnose(Request(model, (tables[0],), (tables[1],)))
    except BadInputError as error:
        return found | {"verdict": "impossible", "why": str(error)}
    told = [f"{t.standing.label[0]} {t.standing.label[1]}" for t in result.told]
    left = float(result.null.left().max())
    return found | {"verdict": result.decision.kind.value, "told": told, "left": left}


def shares_shown(cases: list[dict[str, Any]]) -> list[tuple[float, int, int]]:
    """Share of the foreseen size, cases in which something was shown, and cases."""
    nothing = {kind.value for kind in NOTHING}
    judged = [case for case in cases if case["verdict"] not in ("stopped", "impossible")]
    found = []
    for share in SHARES:
        mine = [case for case in judged if case["share"] == share]
        found.append((share, sum(case["verdict"] not in nothing for case in mine), len(mine)))
    return found


def picture(cases: list[dict[str, Any]]) -> str:
    """Every case as a mark, full where something was shown, in a row for each effect and axis; shares below."""
    nothing = {kind.value for kind in NOTHING}
    rows = sorted({(case["name"], case["axis"]) for case in cases})
    width, line, top, left, step = 640, 18, 46, 260, 120
    height = top + line * len(rows) + 44
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}"'
        ' font-family="sans-serif" font-size="12">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
        '<text x="12" y="20">full: discrepancy tells something; empty: it says that nothing is missing</text>',
    ]
    at = {share: left + step * i for i, share in enumerate(SHARES)}
    parts += [f'<text x="{x}" y="40" text-anchor="middle">{share:g} x foreseen</text>' for share, x in at.items()]
    for i, (name, axis) in enumerate(rows):
        y = top + line * i + 12
        parts.append(f'<text x="{left - 50}" y="{y}" text-anchor="end">{name.replace("_", " ")}, {axis}</text>')
        for case in cases:
            if (case["name"], case["axis"]) == (name, axis) and case["verdict"] not in ("stopped", "impossible"):
                fill = "white" if case["verdict"] in nothing else "#1f5fa8"
                mark = f'cx="{at[case["share"]]}" cy="{y - 4}" r="5" fill="{fill}" stroke="#1f5fa8"'
                parts.append(f"<circle {mark}/>")
    for (share, shown, of), aimed in zip(shares_shown(cases), AIMED, strict=True):
        said = f"{shown} of {of}" + (f" ({100 * shown / of:.0f} %)" if of else "")
        parts.append(f'<text x="{at[share]}" y="{height - 24}" text-anchor="middle">{said}</text>')
        parts.append(
            f'<text x="{at[share]}" y="{height - 8}" text-anchor="middle" fill="#555">aim {100 * aimed:.0f} %</text>'
        )
    return "\n".join([*parts, "</svg>"]) + "\n"


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--out", type=Path, default=Path("testable_calibration.jsonl"))
    parser.add_argument("--only", default="", help="effects, with commas; all without")
    parser.add_argument("--axes", default="outer,inner")
    parser.add_argument("--seconds", type=float, default=200.0, help="begin no further case after so long")
    parser.add_argument("--picture", type=Path, help="draw the outcomes (SVG)")
    asked = parser.parse_args()
    cases = [json.loads(line) for line in asked.out.read_text().splitlines()] if asked.out.exists() else []
    done = {(case["name"], case["axis"], case["share"]) for case in cases}
    model, begun = shipped_model(), time.monotonic()
    table = survey(model, 0, 3)
    assert table is not None
    wanted = [one for one in foreseen(model, table).shows if one.axis in asked.axes.split(",") and not one.as_tried]
    wanted = [one for one in wanted if not asked.only or one.name in asked.only.split(",")]
    for one, share in ((one, share) for one in wanted for share in SHARES):
        if (one.name, one.axis, share) in done or time.monotonic() - begun > asked.seconds:
            continue
        cases.append(outcome(model, one, share))
        with asked.out.open("a") as file:
            file.write(json.dumps(cases[-1]) + "\n")
        told = ", ".join(cases[-1].get("told", ()))
        print(f"{one.name} {one.axis} x {share:g}: {cases[-1]['verdict']} {told}", flush=True)
    for share, shown, of in shares_shown(cases):
        print(f"{share:g} x the foreseen size: shown in {shown} of {of}")
    if asked.picture is not None:
        asked.picture.write_text(picture(cases), encoding="utf-8")


if __name__ == "__main__":
    main()
