"""Answers as JUnit XML, which every CI server shows as tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree


@dataclass(frozen=True)
class Case:
    """One answer: what was asked, what came out in words, and whether that fails the build."""

    name: str
    text: str
    failed: bool


def write_junit(path: Path, suite: str, cases: Sequence[Case]) -> None:
    """Write one suite; the text of a case that does not fail stands in its output."""
    failures = sum(case.failed for case in cases)
    root = ElementTree.Element("testsuites")
    top = ElementTree.SubElement(root, "testsuite", name=suite, tests=str(len(cases)), failures=str(failures))
    for case in cases:
        node = ElementTree.SubElement(top, "testcase", classname=suite, name=case.name)
        if case.failed:
            ElementTree.SubElement(node, "failure", message=case.text.splitlines()[0]).text = case.text
        else:
            ElementTree.SubElement(node, "system-out").text = case.text
    ElementTree.indent(root)
    path.parent.mkdir(parents=True, exist_ok=True)
    text = ElementTree.tostring(root, encoding="unicode")
    path.write_text(f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n', encoding="utf-8")
