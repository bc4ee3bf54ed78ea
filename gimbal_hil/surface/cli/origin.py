"""Where the antenna of a log answers: what comes next is run on that one, and not on the shipped antenna."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

_DOOR = "operator.json"


@dataclass(frozen=True)
class LogOrigin:
    """A daemon that runs (`run`, its run folder) or a configuration file; neither for the shipped virtual antenna."""

    config: Path | None = None
    run: Path | None = None
    #: model that was the embedded antenna, where another than the configuration's was asked for
    model: str | None = None
    #: files of an antenna that nothing here moves
    elsewhere: bool = False


def origin_of(logs: Sequence[Path]) -> LogOrigin:
    """What the first log that says so was recorded with; a daemon counts while its door stands open."""
    from firmware_protocol.errors import BadInputError
    from gimbal_hil.data.runs import read_header

    for log in logs:
        if (log / _DOOR).exists():
            return LogOrigin(run=log)
        with suppress(BadInputError):
            words = read_header(log).who.get("command", ())
            through = option_in(words, "--run")
            if through is not None:
                found = origin_of([through])
            else:
                model = next(iter(_values(words, "--model")), None)
                found = LogOrigin(option_in(words, "--config"), model=model)
            if found != LogOrigin():
                return found
    return LogOrigin(elsewhere=bool(logs) and all(log.is_file() for log in logs))


def option_in(words: Sequence[object], name: str) -> Path | None:
    """The file or folder that a recorded command line names, None where it is not there any more."""
    return next((Path(value) for value in _values(words, name) if Path(value).exists()), None)


def _values(words: Sequence[object], name: str) -> list[str]:
    """What a recorded command line gives an option."""
    told = [str(word) for word in words]
    return [after for word, after in pairwise(told) if word == name] + [
        word.removeprefix(f"{name}=") for word in told if word.startswith(f"{name}=")
    ]
