"""What people read: pages, and what they are made of."""

from gimbal_hil.pages.report.blocks import (
    Block,
    Callout,
    Details,
    Heading,
    Listing,
    ModelMotion,
    MovingAntenna,
    Plot,
    Table,
    Text,
    Tiles,
    blocks_in,
    plots_in,
)
from gimbal_hil.pages.report.earlier import EARLIER_DEMO, earlier_demo
from gimbal_hil.pages.report.junit import Case, write_junit
from gimbal_hil.pages.report.made import Made, command_of
from gimbal_hil.pages.report.page import Page
from gimbal_hil.pages.report.quantity import between, counted, from_to, quantity, scaled_unit

__all__ = [
    "EARLIER_DEMO",
    "Block",
    "Callout",
    "Case",
    "Details",
    "Heading",
    "Listing",
    "Made",
    "ModelMotion",
    "MovingAntenna",
    "Page",
    "Plot",
    "Table",
    "Text",
    "Tiles",
    "between",
    "blocks_in",
    "command_of",
    "counted",
    "earlier_demo",
    "from_to",
    "plots_in",
    "quantity",
    "scaled_unit",
    "write_junit",
]
