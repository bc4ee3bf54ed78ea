"""Containers of others (bags, MCAP, ULog, MF4, MATLAB, CAN recordings, workbooks, JSON) as named columns with times."""

from gimbal_hil.data.containers.contents import Container, Contents, SampledGroup
from gimbal_hil.data.containers.guessing import Found, command_line, guessed
from gimbal_hil.data.containers.joining import Joined, column_of, joined
from gimbal_hil.data.containers.naming import time_among
from gimbal_hil.data.containers.registry import CONTAINERS, container_of, contents_of
from gimbal_hil.data.containers.survey import guess, survey

__all__ = [
    "CONTAINERS",
    "Container",
    "Contents",
    "Found",
    "Joined",
    "SampledGroup",
    "column_of",
    "command_line",
    "container_of",
    "contents_of",
    "guess",
    "guessed",
    "joined",
    "survey",
    "time_among",
]
