"""The page on the numbers of a model file, made from the table that validates them.

`docs/reference/model-numbers.md` is what `python -m sim_backend.model.number_page` prints; a test holds the two to each
other.
"""

from __future__ import annotations

import math

from sim_backend.model.numbers import NUMBER_AT, Number

_HEAD = """# Numbers of a model file

Made from `sim_backend/model/numbers.py` by `python -m sim_backend.model.number_page`; do not edit.

Every number that an axis of a [model file](model-file.md) may hold. `friction.coulomb` in the table is `coulomb` in the
section `friction` of the axis. Which ones a model needs depends on its kind: `gimbal-hil check` says what is missing.
`gimbal-hil check --schema model` gives editors the same.

| key | unit | of a linear axis | range | default | meaning |
|---|---|---|---|---|---|
"""


def number_page() -> str:
    """Text of `docs/reference/model-numbers.md`."""
    return _HEAD + "".join(_row(number) for number in NUMBER_AT.values())


def _row(number: Number) -> str:
    linear = "" if number.linear_unit == number.unit else number.linear_unit
    default = "none" if number.default is None else f"as `{number.default}`"
    if isinstance(number.default, int | float):
        default = f"{number.default:g}"
    cells = (f"`{number.path}`", number.unit or "1", linear, _range(number), default, number.text)
    return f"| {' | '.join(cells)} |\n"


def _range(number: Number) -> str:
    low = "" if math.isinf(number.low) else f"{number.low:g}"
    high = "" if math.isinf(number.high) else f"{number.high:g}"
    return f"{low} .. {high}" if low or high else "any"


if __name__ == "__main__":
    print(number_page(), end="")
