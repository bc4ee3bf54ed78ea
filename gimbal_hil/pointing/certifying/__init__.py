"""What a terminal maker shows a regulator: drawn flights, judged by the truth."""

from gimbal_hil.pointing.certifying.certificate import Certificate, ShareInterval, certified, of_all, of_time
from gimbal_hil.pointing.certifying.flight import FlightTask, FlownFlight, PointingRequirement, fly, judged
from gimbal_hil.pointing.certifying.flown_file import FLOWN_FILE, FlownFile
from gimbal_hil.pointing.certifying.navigation import NavigationErrors, load_navigation
from gimbal_hil.pointing.certifying.page import certificate_blocks, certificate_document, summary

__all__ = [
    "FLOWN_FILE",
    "Certificate",
    "FlightTask",
    "FlownFile",
    "FlownFlight",
    "NavigationErrors",
    "PointingRequirement",
    "ShareInterval",
    "certificate_blocks",
    "certificate_document",
    "certified",
    "fly",
    "judged",
    "load_navigation",
    "of_all",
    "of_time",
    "summary",
]
