"""Progress as people see it: one bar, what is being done, how long is left. Nothing where stderr is no terminal."""

from __future__ import annotations

import sys
from functools import lru_cache
from types import TracebackType
from typing import Self, TextIO

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn


def error_console() -> Console:
    """The one console on stderr: displays on the same console stand below each other, on two they overwrite."""
    return _console_of(sys.stderr)


@lru_cache(maxsize=1)
def _console_of(stream: TextIO) -> Console:
    return Console(file=stream)


class ProgressBar:
    """A bar over simulated or real seconds, as a context manager; a `ProgressSink` for the experiment runner."""

    def __init__(self, enabled: bool = True) -> None:
        self._progress = Progress(
            TextColumn("{task.fields[title]}"),
            BarColumn(bar_width=28),
            TextColumn("{task.percentage:>3.0f} %"),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            TextColumn("{task.description}", style="dim"),
            console=error_console(),
            disable=not (enabled and sys.stderr.isatty()),
            transient=True,
        )
        self._task: TaskID | None = None

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._progress.stop()

    def begin(self, text: str, total_s: float, done_s: float) -> None:
        """A new piece of work of `total_s` seconds (or units), `done_s` of them done."""
        if self._task is not None:
            self._progress.update(self._task, visible=False)
        self._task = self._progress.add_task("", total=total_s, title=text)
        self._progress.update(self._task, completed=done_s)

    def at(self, step: str, advanced_s: float) -> None:
        """So much more is done; `step` is what goes on now."""
        if self._task is not None:
            self._progress.update(self._task, advance=advanced_s, description=step)
