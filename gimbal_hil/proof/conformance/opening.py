"""From a configuration to the antenna that is to be tested."""

from __future__ import annotations

from firmware_protocol.errors import LinkError
from firmware_protocol.links import AntennaInStep, require_can_wait
from firmware_protocol.opening import open_link
from gimbal_hil.loop.settings import DaemonSettings, EmbeddedAntenna
from gimbal_hil.proof.conformance.carriers import Carrier, InStep, OverLink
from sim_backend.firmware import run_firmware
from sim_backend.firmware_run import FirmwareRun
from sim_backend.model import model_named


def open_antenna(settings: DaemonSettings, *, lockstep: bool = False) -> Carrier:
    """The virtual antenna in this process, in step; or whatever sends feedback on the link, in `lockstep` whatever
    waits there for this process; LinkError where nothing does.
    """
    link = settings.link
    if isinstance(link, EmbeddedAntenna):
        embedded, own = link.embedded, link.embedded.firmware is FirmwareRun.VIRTUAL
        model = model_named(embedded.model, "link.embedded.model")
        device = run_firmware(embedded.firmware, model, settings.rate_hz, embedded.seed)
        kind = "virtual antenna" if own else f"C device ({embedded.firmware}) with antenna"
        return InStep(device, f"{kind} {device.model.name}", settings.rate_hz)
    if lockstep:
        require_can_wait(link)
        antenna = AntennaInStep(open_link(link))
        return InStep(antenna, f"{antenna.name} in lockstep", settings.rate_hz)
    carrier = OverLink(open_link(link), settings.rate_hz)
    if not carrier.heard():
        carrier.close()
        raise LinkError(f"{carrier.name} is open, but no antenna answered within 5 s; expected feedback from power-on")
    return carrier
