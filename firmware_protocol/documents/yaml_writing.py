"""YAML as this project writes it: keys in their order, no aliases, and text in quotes wherever it would be read as
something else.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from typing import Any

from firmware_protocol.documents.yaml_reading import FLOAT


def yaml_text(document: Mapping[str, Any], leaves_in_line: bool = False) -> str:
    """The text of a document that `yaml_mapping` reads back as it is; `leaves_in_line` writes the tables that hold no
    other one in braces, for people.
    """
    import yaml

    flow = None if leaves_in_line else False
    return yaml.dump(
        dict(document), Dumper=_dumper(), default_flow_style=flow, sort_keys=False, allow_unicode=True, width=120
    )


@cache
def _dumper() -> Any:
    import yaml

    class Dumper(yaml.SafeDumper):
        def ignore_aliases(self, data: Any) -> bool:
            return True

    # PyYAML takes 1e-3 for text and writes such text without quotes; here it is a number
    Dumper.add_implicit_resolver("tag:yaml.org,2002:float", re.compile(f"^(?:{FLOAT.pattern})$"), list("-+.0123456789"))
    return Dumper
