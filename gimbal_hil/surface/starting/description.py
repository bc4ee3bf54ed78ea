"""What a person knows of an antenna before anything was measured, and what stands in for what he does not know."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace

from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from sim_backend.boresight import Boresight
from sim_backend.model import ModelKind

#: a body of which only the mass is given is a ball of this radius, m
_BALL_M = 0.2
#: friction over the torque limit, break-away over Coulomb, viscous over Coulomb (s/rad), of an axis nobody measured
_COULOMB_SHARE, _BUMP, _VISCOUS_SHARE = 0.015, 1.07, 0.25
#: bristles bend so far before they break away, rad (m), with this damping of the inertia on them
_BRISTLE, _BRISTLE_DAMPING = 1e-3, 0.5
_STRIBECK = 0.01
_SIZES = {
    ModelKind.GIMBAL: ({"mass_kg": 12.0, "torque_nm": 15.0}, {"mass_kg": 5.0, "torque_nm": 6.0}),
    ModelKind.ROTARY: ({"mass_kg": 12.0, "torque_nm": 15.0},),
    ModelKind.LINEAR: ({"mass_kg": 20.0, "torque_nm": 300.0},),
}
_NAMES = {ModelKind.GIMBAL: ("azimuth", "elevation"), ModelKind.ROTARY: ("joint",), ModelKind.LINEAR: ("carriage",)}
STATED, ASSUMED = "stated at init", "assumed"
_LINKS = "virtual, unix:PATH, serial:PORT, socketcan:CHANNEL, slcan:PORT, or a drive: moteus:, odrive:, cia402:CHANNEL"
#: ticks a second on a link between processes: the longest stall that is survived is a number of ticks
_BETWEEN_PROCESSES_HZ = 500.0
#: drives of other makes, and the bit rate of CAN FD where they need it
_DRIVES: dict[str, int | None] = {"moteus": 5_000_000, "odrive": None, "cia402": None}


@dataclass(frozen=True)
class AxisDescription:
    """Numbers of one axis in SI units (N, kg and m on a linear axis); None where nobody told it."""

    name: str
    mass_kg: float | None = None
    inertia_kg_m2: float | None = None
    #: largest distance of the centre of gravity from the axis
    offset_m: float | None = None
    coulomb_nm: float | None = None
    breakaway_nm: float | None = None
    viscous_nm_s: float | None = None
    torque_nm: float | None = None
    #: of a drive that logs its current
    torque_constant_nm_a: float | None = None
    rate_rad_s: float | None = None
    travel_rad: tuple[float, float] | None = None
    encoder_counts: float | None = None
    told: frozenset[str] = frozenset()

    def stated(self) -> AxisDescription:
        """The same, with what has been told marked as such."""
        told = {
            one.name for one in fields(self) if one.name not in ("name", "told") and getattr(self, one.name) is not None
        }
        return replace(self, told=frozenset(told))

    def source(self, *names: str) -> str:
        """Where a number that follows from these comes from."""
        return STATED if self.told.intersection(names) else ASSUMED


@dataclass(frozen=True)
class LinkChoice:
    """How the antenna is reached: a word for people, and the `link` section of the configuration."""

    word: str
    section: Json = field(default_factory=dict)
    rate_hz: float = 1000.0

    @property
    def is_drives(self) -> bool:
        """Whether two drives of another make are at its other end."""
        return self.section.get("kind") == "adapter"

    @property
    def tells_rate(self) -> bool:
        """Whether its drives tell a rate of their own beside the position; a DBC may lack it."""
        if self.section.get("drive") != "dbc":
            return self.is_drives
        from firmware_protocol.adapters import Gives, gives_of
        from firmware_protocol.links import DriveSection

        mapped = [DriveSection.model_validate(one) for one in self.section.get("drives", ())]
        return bool(mapped) and all(Gives.RATE in gives_of("dbc", one) for one in mapped)

    @property
    def is_simulated(self) -> bool:
        """Whether at its other end is another process of this machine: no hardware."""
        return self.section.get("kind") == "unix" or self.section.get("interface") == "unix"

    @property
    def is_virtual(self) -> bool:
        """Whether the antenna is in the program itself."""
        return self.word == "virtual"


@dataclass(frozen=True)
class AntennaDescription:
    """A whole antenna, the carrying axis first."""

    name: str
    kind: ModelKind
    axes: tuple[AxisDescription, ...]
    link: LinkChoice
    rate_hz: float
    has_gyro: bool = True
    boresight: Boresight = Boresight.AHEAD
    #: of one axis alone: rotary, from the vertical (90: it lies level); linear, its slope
    tilt_deg: float = 0.0
    tilt_told: bool = False


def usual_boresight(axes: Sequence[AxisDescription]) -> Boresight:
    """Which way is up for axes of which only their travel says it: an antenna looks further up than down."""
    low, high = axes[-1].travel_rad or (0.0, 0.0)
    return Boresight.ASTERN if low + high > 0.0 else Boresight.AHEAD


def usual_tilt_deg(kind: ModelKind) -> float:
    """How one axis alone lies while nobody said it: a rotary one level, where a weight off it acts if it has one."""
    return 90.0 if kind is ModelKind.ROTARY else 0.0


def usual_names(kind: ModelKind) -> tuple[str, ...]:
    """What the axes of this kind are mostly called."""
    return _NAMES[kind]


def usual_axis(told: AxisDescription, kind: ModelKind, place: int) -> AxisDescription:
    """An axis with everything that was not told filled in; `told` keeps which numbers were."""
    told = told.stated()
    size = _SIZES[kind][place]
    mass = _told(told.mass_kg, size["mass_kg"])
    inertia = mass if kind is ModelKind.LINEAR else _told(told.inertia_kg_m2, 0.4 * mass * _BALL_M**2)
    torque = _told(told.torque_nm, size["torque_nm"])
    assumed = _COULOMB_SHARE * torque if told.breakaway_nm is None else told.breakaway_nm / _BUMP
    coulomb = _told(told.coulomb_nm, assumed)
    return replace(
        told,
        mass_kg=mass,
        inertia_kg_m2=inertia,
        offset_m=_told(told.offset_m, 0.0),
        coulomb_nm=coulomb,
        breakaway_nm=_told(told.breakaway_nm, _BUMP * coulomb),
        viscous_nm_s=_told(told.viscous_nm_s, _VISCOUS_SHARE * coulomb),
        torque_nm=torque,
        rate_rad_s=_told(told.rate_rad_s, 6.0),
        travel_rad=told.travel_rad or (None if place == 0 else (-2.0, 2.0)),
        encoder_counts=_told(told.encoder_counts, 2.0**20),
    )


def _told(number: float | None, usual: float) -> float:
    """What was told, zero too: an air bearing has no friction."""
    return usual if number is None else number


def friction_of(axis: AxisDescription, kind: ModelKind) -> dict[str, tuple[float, str]]:
    """LuGre numbers of a described axis, each with its source.

    One axis alone is for logs of its own and starts without bristles: those that nobody told of would be searched for
    in place of what is there. The antenna of a gimbal moves in a simulation and has them.
    """
    assert axis.coulomb_nm is not None and axis.breakaway_nm is not None and axis.viscous_nm_s is not None
    assert axis.inertia_kg_m2 is not None
    stiffness = axis.breakaway_nm / _BRISTLE if kind is ModelKind.GIMBAL else 0.0
    damping = 2.0 * _BRISTLE_DAMPING * math.sqrt(stiffness * axis.inertia_kg_m2)
    bump = axis.breakaway_nm - axis.coulomb_nm
    # beyond this the bristles would give energy back
    most = 0.9 * axis.viscous_nm_s * axis.coulomb_nm / bump if bump > 0.0 else damping
    return {
        "coulomb": (axis.coulomb_nm, axis.source("coulomb_nm", "breakaway_nm")),
        "breakaway": (axis.breakaway_nm, axis.source("breakaway_nm", "coulomb_nm")),
        "stribeck_velocity": (_STRIBECK, ASSUMED),
        "shape": (1.0, ASSUMED),
        "sigma0": (stiffness, ASSUMED),
        "sigma1": (min(damping, most), ASSUMED),
        "viscous": (axis.viscous_nm_s, axis.source("viscous_nm_s")),
    }


def parse_link(text: str) -> LinkChoice:
    """A link as a person writes it, `KIND` or `KIND:PLACE`; BadInputError lists the kinds."""
    kind, _, place = text.partition(":")
    if kind == "virtual" and not place:
        return LinkChoice("virtual")
    if not place:
        raise BadInputError("--link", f"{text!r} is no link", _LINKS)
    if kind == "unix":
        return LinkChoice(kind, {"kind": "unix", "path": place}, _BETWEEN_PROCESSES_HZ)
    if kind == "serial":
        return LinkChoice(kind, {"kind": "serial", "port": place})
    if kind in ("socketcan", "slcan"):
        return LinkChoice(kind, {"kind": "can", "interface": kind, "channel": place, "bitrate": 1_000_000})
    if kind in _DRIVES:
        # a socket of simulated drives has a path, a bus a name
        interface, channel = ("unix", place.removeprefix("unix:")) if "/" in place else ("socketcan", place)
        section = {"kind": "adapter", "drive": kind, "interface": interface, "channel": channel}
        rate_hz = _BETWEEN_PROCESSES_HZ if interface == "unix" else 1000.0
        return LinkChoice(kind, section | ({"data_bitrate": _DRIVES[kind]} if _DRIVES[kind] else {}), rate_hz)
    raise BadInputError("--link", f"no link {kind!r}", _LINKS)
