"""Figures as a page carries them: rounded to what a picture shows, one text for all, compressed.

A double has seventeen digits and a picture a thousand dots: the last twelve digits are noise that no compression takes
away. Numbers are rounded to a hundred-thousandth of their range, which one can zoom into a hundred times; small ones
keep four digits.
"""

from __future__ import annotations

import base64
import gzip
import json
import math
from collections.abc import Sequence
from importlib.resources import files
from typing import Any

import numpy as np

from firmware_protocol.json_object import Json
from gimbal_hil.pages.plots import Drawing

#: steps that the range of an array is cut into
STEPS = 100_000


def packed(figures: Sequence[Drawing]) -> str:
    """All figures of a page and their templates, each of them once however often it is shown: JSON, gzip, base64."""
    templates: dict[str, int] = {}
    found: dict[str, int] = {}
    places = []
    for figure in figures:
        document = figure.to_dict()
        template = json.dumps(document["layout"].pop("template", {}), sort_keys=True)
        layout = _light(document["layout"])
        data = [_light(trace) for trace in document["data"]]
        one = {"data": data, "layout": layout, "template": templates.setdefault(template, len(templates))}
        text = json.dumps(one, separators=(",", ":"), allow_nan=False)
        places.append(found.setdefault(text, len(found)))
    text = f'{{"templates":[{",".join(templates)}],"figures":[{",".join(found)}],"places":{json.dumps(places)}}}'
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


def unpacked(text: str) -> Json:
    """What `packed` was given, as plain JSON: `figures` and `templates`."""
    found: Json = json.loads(gzip.decompress(base64.b64decode(text)))
    return {"figures": [found["figures"][place] for place in found["places"]], "templates": found["templates"]}


def drawing_library() -> str:
    """plotly.js with the lines, points and bars that reports draw (its "basic" bundle): gzip, base64."""
    return base64.b64encode(
        (files("gimbal_hil.pages.report") / "static" / "plotly-basic.min.js.gz").read_bytes()
    ).decode()


def rounded(values: np.ndarray) -> list[Any]:
    """Numbers of any shape, to a hundred-thousandth of their range; what is not finite becomes None."""
    if values.dtype.kind != "f":
        return list(values.tolist())
    finite = values[np.isfinite(values)]
    span = float(np.ptp(finite)) if finite.size else 0.0
    if span == 0.0:
        return list(_plain(values.tolist(), 15, 0.0))
    decimals = min(int(np.ceil(np.log10(STEPS / span))), 300)
    # what is small keeps four digits of its own: on a logarithmic axis it is as large as the rest
    return list(_plain(values.tolist(), decimals, 10.0 ** (3 - decimals)))


def _plain(values: list[Any], decimals: int, small: float) -> list[Any]:
    found: list[object] = []
    for value in values:
        if isinstance(value, list):
            found.append(_plain(value, decimals, small))
        elif not math.isfinite(value):
            found.append(None)
        else:
            found.append(float(f"{value:.3e}") if abs(value) < small else round(value, decimals))
    return found


def _light(value: Any) -> Any:
    """Plain JSON, arrays rounded."""
    if isinstance(value, dict):
        return {key: _light(inner) for key, inner in value.items()}
    if isinstance(value, np.ndarray):
        return rounded(value) if value.dtype.kind in "fiub" else [_light(one) for one in value.tolist()]
    if isinstance(value, (list, tuple)):
        numbers = bool(value) and all(isinstance(one, (float, np.floating)) for one in value)
        return rounded(np.asarray(value, float)) if numbers else [_light(one) for one in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not np.isfinite(value) else value
