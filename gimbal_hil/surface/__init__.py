"""Surface: where people come in.

cli         one file a command
library     what scripts and notebooks use: `from gimbal_hil import Run, Antenna, identify, find_discrepancy`
testing     signals with assertions and the pytest plugin
checking    files that people write: recognised, checked, their schemas
starting    files of a user's own antenna from a few numbers
demo        the whole workflow in a few stages and one page
deployment  systemd unit, container file, Grafana dashboard, man pages
warming     every kernel compiled once

On top of everything; nothing below imports from here.
"""
