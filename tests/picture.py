"""The picture at the top of the README, from the report of the demo:

gimbal-hil demo --out demo && python -m tests.picture demo/report.html docs/pictures/antenna.png
"""

from __future__ import annotations

import base64
import sys
from pathlib import Path

from tests.browser import Browser

#: CSS pixels, and the second of the motion that is shown
WIDTH, HEIGHT, AT_S = 760, 900, 16.0
#: nothing is drawn in the upper part of the canvas while the antenna looks at the horizon
EMPTY = 90


def picture_of(report: Path) -> bytes:
    """PNG of the antenna and its model's ghost, with what is said below it."""
    figure = "document.querySelector('figure.motion')"
    with Browser(WIDTH, HEIGHT) as browser:
        browser.open(report.resolve().as_uri(), f"{figure} && {figure}.querySelector('output').textContent")
        browser.value(f"{figure}.scrollIntoView(); 1")
        browser.value(f"(s => {{ s.value = {AT_S}; s.oninput(); }})({figure}.querySelector('input')); 1")
        browser.until(f"{figure}.querySelector('output').textContent.startsWith('{AT_S:.1f} s')")
        canvas, said = (
            browser.value(f"(r => [r.left, r.top + scrollY, r.width, r.bottom + scrollY])({box})")
            for box in (f"{figure}.querySelector('{name}').getBoundingClientRect()" for name in ("canvas", "output"))
        )
        box = (canvas[0], canvas[1] + EMPTY, canvas[2], said[3] - canvas[1] - EMPTY)
        clip = dict(zip(("x", "y", "width", "height"), box, strict=True)) | {"scale": 1}
        told = browser.ask("Page.captureScreenshot", captureBeyondViewport=True, clip=clip)
    return base64.b64decode(told["data"])


if __name__ == "__main__":
    Path(sys.argv[2]).write_bytes(picture_of(Path(sys.argv[1])))
