"""Export of a run to other formats, with the same signal names in all of them."""

from gimbal_hil.data.exports.blf_file import export_blf
from gimbal_hil.data.exports.groups import ExportedSignal, Group, Progress, groups_of
from gimbal_hil.data.exports.layouts import foxglove_layout, plotjuggler_layout
from gimbal_hil.data.exports.mat_file import export_mat
from gimbal_hil.data.exports.mcap_file import export_mcap
from gimbal_hil.data.exports.mf4_file import export_mf4
from gimbal_hil.data.exports.ros2_bag import export_ros2

__all__ = [
    "ExportedSignal",
    "Group",
    "Progress",
    "export_blf",
    "export_mat",
    "export_mcap",
    "export_mf4",
    "export_ros2",
    "foxglove_layout",
    "groups_of",
    "plotjuggler_layout",
]
