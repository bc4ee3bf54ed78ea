"""Documents that people and programs hand in (YAML and JSON): read with limits, checked strictly, refused in one clear
line.
"""

from firmware_protocol.documents.copying import copied
from firmware_protocol.documents.json_reading import json_line, read_json
from firmware_protocol.documents.key_tables import Column, key_table
from firmware_protocol.documents.limits import DocumentLimits, printable, require_regular, text_problem
from firmware_protocol.documents.refusal import Refusals, validated
from firmware_protocol.documents.strict import LARGEST_NUMBER, Strict, with_strict_numbers
from firmware_protocol.documents.yaml_editing import yaml_edited
from firmware_protocol.documents.yaml_reading import read_yaml, yaml_mapping
from firmware_protocol.documents.yaml_writing import yaml_text

__all__ = [
    "LARGEST_NUMBER",
    "Column",
    "DocumentLimits",
    "Refusals",
    "Strict",
    "copied",
    "json_line",
    "key_table",
    "printable",
    "read_json",
    "read_yaml",
    "require_regular",
    "text_problem",
    "validated",
    "with_strict_numbers",
    "yaml_edited",
    "yaml_mapping",
    "yaml_text",
]
