"""Links that lead outside docs/: the project's own pages join the site, links to source files become plain words.

The pages are read in the checkout too, where such links lead to the files themselves.
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parent.parent.parent
#: pages at the top of the checkout, as they are called in the site
JOINED = {name: f"project/{name}" for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "LICENSE")}
_LINK = re.compile(r"\[(?P<text>[^\]]*)\]\((?P<target>[^)#\s]*)(?P<anchor>#[^)]*)?\)")


def on_files(files: Files, config: Any) -> Files:
    """Let the project's own pages join."""
    for name, place in JOINED.items():
        target = place if place.endswith(".md") else f"{place}.md"
        text = (ROOT / name).read_text(encoding="utf-8")
        content = text if name.endswith(".md") else f"# {name}\n\n```text\n{text}\n```\n"
        files.append(File.generated(config, target, content=content))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Have every link lead to a page of the site, or none."""
    place = page.file.src_uri
    own = posixpath.basename(place) if place in {f"project/{name}" for name in JOINED} else None
    here = "" if own else posixpath.join("docs", posixpath.dirname(place))

    def led(found: re.Match[str]) -> str:
        text, target, anchor = found["text"], found["target"], found["anchor"] or ""
        if not target or "://" in target or target.startswith("mailto:"):
            return found[0]
        path = posixpath.normpath(posixpath.join(here, target))
        if path in JOINED:
            to = JOINED[path] if path.endswith(".md") else f"{JOINED[path]}.md"
        elif path.startswith("docs/") and (ROOT / path).is_file():
            to = path.removeprefix("docs/")
        elif path.startswith("docs/") and (ROOT / path / "README.md").is_file():
            to = f"{path.removeprefix('docs/')}/README.md"
        elif (ROOT / path).exists():
            return text
        else:
            return found[0]
        return f"[{text}]({posixpath.relpath(to, posixpath.dirname(place) or '.')}{anchor})"

    return _LINK.sub(led, markdown)
