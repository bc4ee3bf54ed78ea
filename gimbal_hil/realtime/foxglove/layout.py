"""A layout for Foxglove that shows what `serve` sends: the antenna, positions, rates, torques, states and events."""

from __future__ import annotations

from collections.abc import Sequence


def layout_of(axes: Sequence[str]) -> str:
    """JSON to import in Foxglove (Layouts, Import from file), for a daemon with these axes."""
    from foxglove import layouts as made

    def plot(title: str, *keys: str) -> made.SplitItem:
        paths = [
            made.PlotSeries(value=f"/axes/{axis}.{key}", label=f"{axis} {key}", enabled=True)
            for axis in axes
            for key in keys
        ]
        return made.SplitItem(content=made.PlotPanel(title=title, config=made.PlotConfig(paths=paths)))

    plots = [
        plot("Position (deg)", "position_deg", "position_ref_deg"),
        plot("Rate (rad/s)", "rate_rad_s"),
        plot("Torque (N m)", "torque_nm", "missing_torque_rms_nm"),
    ]
    scene = made.ThreeDeePanel(
        config=made.ThreeDeeConfig(
            follow_tf="world", topics={"/antenna": made.BaseRendererSceneUpdateTopicSettings(visible=True)}
        )
    )
    states = made.RawMessagesPanel(config=made.RawMessagesConfig(topic_path="/state"))
    seen = made.SplitContainer(
        direction="column",
        items=[
            made.SplitItem(proportion=2.0, content=scene),
            made.SplitItem(content=states),
            made.SplitItem(content=made.LogPanel(config=made.LogConfig(topic_to_render="/events"))),
        ],
    )
    drawn = made.SplitContainer(direction="column", items=plots)
    items = [made.SplitItem(content=seen), made.SplitItem(content=drawn)]
    return made.Layout(content=made.SplitContainer(direction="row", items=items)).to_json()
