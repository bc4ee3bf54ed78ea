"""What people read: pages and the look of figures (`figures` is imported where plotly is needed)."""

from gimbal_hil.report.page import Block, Callout, Details, Heading, Listing, Page, Plot, Table, Text, Tiles

__all__ = ["Block", "Callout", "Details", "Heading", "Listing", "Page", "Plot", "Table", "Text", "Tiles"]
