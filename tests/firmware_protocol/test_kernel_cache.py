"""Compiled code is not loaded from where somebody else could have put it."""

from __future__ import annotations

from pathlib import Path

import pytest

from firmware_protocol.compiling import require_own
from firmware_protocol.errors import BadInputError


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
