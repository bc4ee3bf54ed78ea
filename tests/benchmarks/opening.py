"""How long a report takes to open: from navigation until every figure in the window is drawn, in headless Chromium.

`python -m tests.benchmarks.opening PAGE...` opens each page in a browser of its own, several times in turn, and prints
median and spread of each by the browser's own clock, with size and length of the page.
"""

from __future__ import annotations

import argparse
import statistics
from pathlib import Path

from tests.browser import Browser

#: the moment at which no figure in the window is left to draw and the browser has painted, ms after navigation
_WATCH = """
(() => {
  const seen = () => [...document.querySelectorAll('.plot')].filter(p => {
    const r = p.getBoundingClientRect(); return r.width && r.top < innerHeight && r.bottom > 0; });
  const look = () => {
    if (document.readyState === 'complete' && seen().every(p => p.dataset.drawn))
      requestAnimationFrame(() => setTimeout(() => { window.opened_ms = performance.now(); }));
    else requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
})()
"""


def opened_ms(page: Path, width: int, height: int) -> float:
    """Milliseconds from navigation until the figures in view are painted, in a browser that has opened nothing yet."""
    with Browser(width, height) as browser:
        browser.ask("Page.addScriptToEvaluateOnNewDocument", source=_WATCH)
        browser.open(page.resolve().as_uri(), "window.opened_ms")
        return float(browser.value("window.opened_ms"))


def main() -> None:
    """Print one line for each page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("pages", nargs="+", type=Path)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--width", type=int, default=1200)
    parser.add_argument("--height", type=int, default=1000)
    asked = parser.parse_args()
    times: dict[Path, list[float]] = {page: [] for page in asked.pages}
    for _ in range(asked.repeats):
        for page in asked.pages:
            times[page].append(opened_ms(page, asked.width, asked.height))
    for page, found in times.items():
        told = f"{statistics.median(found) / 1e3:5.2f} s  ({min(found) / 1e3:.2f} to {max(found) / 1e3:.2f})"
        print(f"{told}  {page.stat().st_size / 1e6:.2f} MB  {page}")


if __name__ == "__main__":
    main()
