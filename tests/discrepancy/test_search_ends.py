"""A search that comes to nothing new is over."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from gimbal_hil.discrepancy.search import search


@pytest.mark.parametrize("still_pays", [False, True])
def test_several_numbers_of_which_nothing_new_is_left_end_the_round(
    still_pays: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, several, pruned = (SimpleNamespace(name=name) for name in ("before", "several", "pruned"))
    inquiry: Any = SimpleNamespace()
    monkeypatch.setattr(search, "candidates", lambda *_: [])
    monkeypatch.setattr(search, "released", lambda *_: several)
    monkeypatch.setattr(search, "pruned", lambda *_: (pruned, {}))
    monkeypatch.setattr(search, "_takes_over", lambda i, b, f, state: state is several or still_pays)
    path = search.Path(before, (), ())  # type: ignore[arg-type]
    ended = search.one_more(inquiry, path, release=True, room=1).state
    assert ended is (pruned if still_pays else before)
