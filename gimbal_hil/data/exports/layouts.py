"""Layouts for the programs that open an MCAP: panels of position, rate and torque of both axes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from xml.etree import ElementTree

from gimbal_hil.data.exports.groups import Group
from gimbal_hil.data.signals import unit_of

#: a panel each: what is drawn together
_PANELS = (("position", "position_ref"), ("rate", "rate_ref"), ("torque", "torque_measured"))
_COLOURS = ("#1f6f8b", "#8a94a0", "#d1603d", "#6a4c93")


def panels_of(groups: Sequence[Group], axes: Sequence[str]) -> list[tuple[str, list[tuple[str, str]]]]:
    """(title with unit, signals as (group, channel)) of every panel that the groups can fill."""
    there = {(group.name, channel.name) for group in groups for channel in group.channels}
    panels = []
    for kinds in _PANELS:
        drawn = [(axis, kind) for axis in axes for kind in kinds if (axis, kind) in there]
        if drawn:
            panels.append((f"{kinds[0]} [{unit_of('.'.join(drawn[0]))}]", drawn))
    return panels


def foxglove_layout(groups: Sequence[Group], axes: Sequence[str]) -> str:
    """A layout to import into Foxglove."""
    panels = panels_of(groups, axes)
    plots: dict[str, object] = {}
    for title, drawn in panels:
        plots[f"Plot!{drawn[0][1]}"] = {
            "foxglovePanelTitle": title,
            "paths": [
                {
                    "value": f"/{group}.{channel}",
                    "label": f"{group}.{channel}",
                    "enabled": True,
                    "timestampMethod": "publishTime",
                    "color": _COLOURS[place % len(_COLOURS)],
                }
                for place, (group, channel) in enumerate(drawn)
            ],
            "xAxisVal": "timestamp",
            "isSynced": True,
            "showLegend": True,
            "legendDisplay": "floating",
        }
    states = "StateTransitions!states"
    there = {group.name for group in groups}
    paths = [("host.host_state", "host"), ("drive_status.state", "drive_status")]
    plots[states] = {
        "paths": [
            {"value": f"/{path}", "label": path, "timestampMethod": "publishTime"}
            for path, group in paths
            if group in there
        ],
        "isSynced": True,
    }
    return json.dumps(
        {
            "configById": plots,
            "globalVariables": {},
            "userNodes": {},
            "playbackConfig": {"speed": 1},
            "layout": _column(list(plots)),
        },
        indent=2,
    )


def _column(names: list[str]) -> object:
    """Panels below each other, equally high."""
    if len(names) == 1:
        return names[0]
    share = 100.0 / len(names)
    return {"direction": "column", "first": names[0], "second": _column(names[1:]), "splitPercentage": share}


def plotjuggler_layout(groups: Sequence[Group], axes: Sequence[str]) -> str:
    """A layout file of PlotJuggler for the same MCAP."""
    panels = panels_of(groups, axes)
    root = ElementTree.Element("root")
    main = ElementTree.SubElement(root, "tabbed_widget", {"name": "Main Window", "parent": "main_window"})
    tab = ElementTree.SubElement(main, "Tab", tab_name="gimbal-hil", containers="1")
    container = ElementTree.SubElement(tab, "Container")
    sizes = ";".join([f"{1.0 / len(panels):.6f}"] * len(panels)) if panels else ""
    splitter = ElementTree.SubElement(container, "DockSplitter", orientation="-", count=str(len(panels)), sizes=sizes)
    for title, drawn in panels:
        area = ElementTree.SubElement(splitter, "DockArea", name=title)
        plot = ElementTree.SubElement(area, "plot", mode="TimeSeries", style="Lines")
        for place, (group, channel) in enumerate(drawn):
            ElementTree.SubElement(plot, "curve", name=f"/{group}/{channel}", color=_COLOURS[place % len(_COLOURS)])
    ElementTree.SubElement(main, "currentTabIndex", index="0")
    ElementTree.SubElement(root, "use_relative_time_offset", enabled="1")
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"
