"""Files for a machine that runs the daemon for good: systemd unit, container file, Grafana dashboard, man pages."""

from gimbal_hil.surface.deployment.container import container_file
from gimbal_hil.surface.deployment.grafana import grafana_dashboard
from gimbal_hil.surface.deployment.manual import manual_page
from gimbal_hil.surface.deployment.unit import UNIT_NAME, UnitChoice, unit_text

__all__ = ["UNIT_NAME", "UnitChoice", "container_file", "grafana_dashboard", "manual_page", "unit_text"]
