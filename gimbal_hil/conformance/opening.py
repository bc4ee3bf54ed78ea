"""From a configuration to the antenna that is to be tested."""

from __future__ import annotations

from firmware_protocol.errors import LinkError
from firmware_protocol.links import AntennaInStep, open_link, require_can_wait
from gimbal_hil.conformance.carriers import Carrier, InStep, OverLink
from gimbal_hil.settings import DaemonSettings, EmbeddedAntenna
from sim_backend.device import Device
from sim_backend.firmware import FirmwareRun, run_firmware
from sim_backend.model import model_named


def open_antenna(settings: DaemonSettings, firmware: FirmwareRun | None = None, *, lockstep: bool = False) -> Carrier:
    """The virtual antenna in this process, in step, with the C device as its firmware where that is wanted; or whatever
    sends feedback on the link, in `lockstep` whatever waits there for this process; LinkError where nothing does.
    """
    link = settings.link
    if isinstance(link, EmbeddedAntenna) and firmware is not None:
        model = model_named(link.embedded.model)
        run = run_firmware(firmware, model, settings.rate_hz, link.embedded.seed)
        return InStep(run, f"C device ({firmware.value}) with antenna {model.name}", settings.rate_hz)
    if isinstance(link, EmbeddedAntenna):
        device = Device(model_named(link.embedded.model), rate_hz=settings.rate_hz, seed=link.embedded.seed)
        return InStep(device, f"virtual antenna {device.model.name}", settings.rate_hz)
    if lockstep:
        require_can_wait(link)
        antenna = AntennaInStep(open_link(link))
        return InStep(antenna, f"{antenna.name} in lockstep", settings.rate_hz)
    carrier = OverLink(open_link(link), settings.rate_hz)
    if not carrier.heard():
        carrier.close()
        raise LinkError(f"{carrier.name} is open, but no antenna answered within 5 s; expected feedback from power-on")
    return carrier
