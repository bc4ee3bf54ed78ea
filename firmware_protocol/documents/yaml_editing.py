"""Numbers and sections of a YAML file changed in place: every other character, comments too, stays as it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from firmware_protocol.documents.yaml_writing import yaml_text
from firmware_protocol.errors import BadInputError

if TYPE_CHECKING:
    from yaml.nodes import MappingNode, Node


def yaml_edited(text: str, changes: Mapping[str, object], where: str) -> str:
    """The text with the value at each dotted key (`axes.outer.rate_loop.kp_s_per_rad`) replaced, or added at the end of
    the table that it belongs to; tables in between are made. A value is a number, a word, or a table of those, which is
    written in braces.

    BadInputError where a key leads through something that is no table, or a table stands behind an anchor or alias.
    """
    for key, value in changes.items():
        text = _edited(text, key.split("."), value, where)
    return text


def _edited(text: str, path: list[str], value: object, where: str) -> str:
    import yaml

    # PyYAML counts in characters of what it was given, as text is counted here
    node: Node | None = yaml.compose(text, Loader=yaml.SafeLoader)
    if "&" in text and _anchored(text):
        raise BadInputError(where, "uses anchors, which cannot be changed in place", "the values written out")
    for depth, key in enumerate(path):
        if not isinstance(node, yaml.MappingNode):
            raise BadInputError(f"{where}: {'.'.join(path[:depth])}", "is no table", "a table of keys")
        found = next((entry for entry in node.value if entry[0].value == key), None)
        if found is None:
            for missing in reversed(path[depth + 1 :]):
                value = {missing: value}
            return _added(text, node, key, value)
        node = found[1]
    assert node is not None
    begin, end = node.start_mark.index, _end(node)
    if isinstance(node, yaml.MappingNode) and not node.flow_style:
        begin = text.rindex(":", 0, begin) + 1
        return f"{text[:begin]} {_in_line(value)}{text[end:]}"
    return text[:begin] + _in_line(value) + text[end:]


def _end(node: Node) -> int:
    """Where a node's last character is: a table in block style goes on, for the parser, up to the next key."""
    import yaml

    if isinstance(node, yaml.CollectionNode) and not node.flow_style and node.value:
        last = node.value[-1]
        return _end(last[1] if isinstance(last, tuple) else last)
    return int(node.end_mark.index)


def _anchored(text: str) -> bool:
    import yaml

    return any(getattr(event, "anchor", None) for event in yaml.parse(text, Loader=yaml.SafeLoader))


def _added(text: str, table: MappingNode, key: str, value: object) -> str:
    """One more key at the end of a table, in the table's own style."""
    line = f"{key}: {_in_line(value)}"
    if table.flow_style:
        brace = table.end_mark.index - 1
        before = text[:brace].rstrip()
        return before + (", " if table.value else "") + line + text[brace:]
    # a comment behind the last value stays on its line
    newline = text.find("\n", _end(table))
    at = len(text) if newline < 0 else newline
    indent = " " * table.value[0][0].start_mark.column
    return f"{text[:at]}\n{indent}{line}{text[at:]}"


def _in_line(value: object) -> str:
    """A value on one line."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_in_line(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_in_line(one) for one in value) + "]"
    return yaml_text({"value": value}).removeprefix("value: ").rstrip("\n")
