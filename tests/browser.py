"""A headless Chromium for tests of pages: opened pages, keys, pictures, print; skipped where there is none."""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from types import TracebackType
from typing import Any, Self

Json = dict[str, Any]
CHROMIUM = next(
    (found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), None
)
#: a busy machine of two cores starts a browser slowly; nothing asserts how long a thing took
PATIENCE_S = 90.0


class Browser:
    """One window, spoken to by the DevTools protocol over a pair of pipes."""

    def __init__(self, width: int = 1280, height: int = 1000, dark: bool = False) -> None:
        assert CHROMIUM is not None
        self._folder = tempfile.mkdtemp(prefix="gimbal-hil-browser-")
        to_read, self._write = os.pipe()
        self._read, to_write = os.pipe()

        def as_chromium_wants() -> None:
            # pipes of the child at 3 and 4, whatever numbers they have here
            here, there = os.dup(to_read), os.dup(to_write)
            os.dup2(here, 3)
            os.dup2(there, 4)

        words = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars"]
        words += ["--remote-debugging-pipe", f"--user-data-dir={self._folder}", "about:blank"]
        self._process = subprocess.Popen(
            [CHROMIUM, *words],
            preexec_fn=as_chromium_wants,
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_read)
        os.close(to_write)
        self._unread, self._number, self.problems = b"", 0, list[str]()
        target = self._ask("Target.createTarget", url="about:blank")["targetId"]
        self._session = self._ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.ask(f"{domain}.enable")
        self.resize(width, height)
        if dark:
            self.ask("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])

    def open(self, url: str, ready: str = "document.readyState === 'complete'") -> None:
        """Go to a page and wait until an expression in it is true."""
        self.ask("Page.navigate", url=url)
        self.until("location.href !== 'about:blank' && document.readyState === 'complete'")
        self.until(ready)

    def until(self, expression: str) -> None:
        """Wait until it is true."""
        end = time.monotonic() + PATIENCE_S
        while not self.value(f"Boolean({expression})"):
            assert time.monotonic() < end, f"never {expression}; {self.problems}"
            time.sleep(0.05)

    def value(self, expression: str) -> Any:
        """What an expression is in the page."""
        told = self.ask("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in told, told["exceptionDetails"]
        return told["result"].get("value")

    def press(self, key: str, code: int = 0) -> None:
        """One key, on whatever has the focus."""
        text = {"text": key} if len(key) == 1 else {"text": "\r"} if key == "Enter" else {}
        for kind in ("keyDown", "keyUp"):
            self.ask(
                "Input.dispatchKeyEvent", type=kind, key=key, windowsVirtualKeyCode=code or ord(key[0].upper()), **text
            )
            text = {}

    def resize(self, width: int, height: int) -> None:
        """Another window, in CSS pixels."""
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def picture(self, path: Path, whole: bool = True) -> None:
        """The page as a PNG."""
        told = self.ask("Page.captureScreenshot", captureBeyondViewport=whole, **self._clip(whole))
        path.write_bytes(base64.b64decode(told["data"]))

    def printed(self, **options: bool) -> bytes:
        """The page as the PDF that printing gives, with options of `Page.printToPDF`."""
        return base64.b64decode(self.ask("Page.printToPDF", printBackground=True, **options)["data"])

    def ask(self, method: str, **parameters: Any) -> Json:
        """One request to the page."""
        return self._ask(method, self._session, **parameters)

    def close(self) -> None:
        """End it."""
        self._process.kill()
        self._process.wait()
        os.close(self._write)
        os.close(self._read)
        shutil.rmtree(self._folder, ignore_errors=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _clip(self, whole: bool) -> Json:
        if not whole:
            return {}
        size = self.ask("Page.getLayoutMetrics")["cssContentSize"]
        return {"clip": {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}}

    def _ask(self, method: str, session: str | None = None, **parameters: Any) -> Json:
        self._number += 1
        request: Json = {"id": self._number, "method": method, "params": parameters}
        if session is not None:
            request["sessionId"] = session
        os.write(self._write, json.dumps(request).encode() + b"\0")
        while True:
            line = self._line()
            if line.get("id") == self._number:
                assert "error" not in line, line["error"]
                found: Json = line["result"]
                return found
            if line.get("method") == "Runtime.exceptionThrown":
                self.problems.append(json.dumps(line["params"])[:2000])
            elif line.get("method") == "Log.entryAdded" and line["params"]["entry"]["level"] == "error":
                self.problems.append(str(line["params"]["entry"]["text"]))

    def _line(self) -> Json:
        while b"\0" not in self._unread:
            data = os.read(self._read, 1 << 20)
            assert data, "the browser has gone"
            self._unread += data
        line, self._unread = self._unread.split(b"\0", 1)
        found: Json = json.loads(line)
        return found
