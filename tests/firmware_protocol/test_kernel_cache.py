"""Compiled code is not loaded from where somebody else could have put it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from firmware_protocol.errors import BadInputError
from firmware_protocol.kernel_cache import require_own


def test_a_new_cache_is_closed_to_others(tmp_path: Path) -> None:
    require_own(tmp_path / "cache" / "digest")
    assert (tmp_path / "cache" / "digest").stat().st_mode & 0o077 == 0


def test_a_folder_or_a_file_that_others_could_write_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "cache" / "digest"
    folder.mkdir(parents=True, mode=0o755)
    kernel = folder / "kernel.nbc"
    kernel.write_bytes(b"")
    kernel.chmod(0o644)
    require_own(folder)
    for path, mode in ((kernel, 0o666), (folder, 0o777), (folder.parent, 0o775)):
        before = path.stat().st_mode & 0o777
        path.chmod(mode)
        require_own.cache_clear()
        with pytest.raises(BadInputError, match="somebody else could have written"):
            require_own(folder)
        path.chmod(before)


KERNEL = "from firmware_protocol.compiling import entry_point\n\n\n@entry_point\ndef doubled(x):\n    return 2.0 * x\n"
CALLED = "from small_kernel import doubled; print(doubled(3.0), sum(doubled.stats.cache_hits.values()))"


def run_in(folder: Path, source: str, cache: Path) -> str:
    folder.mkdir(exist_ok=True)
    (folder / "small_kernel.py").write_text(source)
    path = os.pathsep.join((str(folder), *sys.path))
    environment = {**os.environ, "PYTHONPATH": path, "GIMBAL_HIL_CACHE": str(cache), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run([sys.executable, "-c", CALLED], env=environment, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_the_same_sources_at_another_place_find_what_was_compiled_and_others_do_not(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    assert run_in(tmp_path / "one", KERNEL, cache) == "6.0 0"
    assert run_in(tmp_path / "two", KERNEL, cache) == "6.0 1"
    assert run_in(tmp_path / "two", KERNEL.replace("2.0", "4.0"), cache) == "12.0 0"
    assert run_in(tmp_path / "two", KERNEL, cache) == "6.0 1"
