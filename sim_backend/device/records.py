"""Everything that the antenna's firmware keeps: state and settings, all in the wire's raw integers.

The firmware computes in whole numbers only: what it compares with a limit is the very number that it reports, and a
copied record goes on bit for bit. Torque counts `TORQUE_STEP_NM` times two to the axis' exponent, position
`POSITION_STEP_RAD`, rate `RATE_STEP_RAD_S`, time ticks; a fraction is a whole number of 1 / 2^16.
"""

from __future__ import annotations

from firmware_protocol.records import Annotated, MemoryRecord, Sequence, layout_of


class Fault(MemoryRecord):
    """A fault given on purpose to a sensor or a motor, see `spoiling`."""

    #: `Spoilt`, and how much, in raw units
    kind: int
    amount: int
    #: ticks since it was given; the value that it keeps
    since: int
    kept: int


class Joint(MemoryRecord):
    """What the firmware keeps of one axis."""

    # --- state
    #: last set-point
    set_torque: int
    set_enable: int
    #: what the drive asks of its current loop
    applied_torque: int
    #: encoder and gyro as sampled; low-passed difference of the encoder
    encoder: int
    gyro: int
    joint_rate: int
    #: winding temperature
    winding: int
    #: FaultCode of this axis' sensors, latched by nothing: as of the last sample
    sensor_fault: int
    #: stopping reference: rate, how far ahead of the joint (fraction of a count), integral of that (torque, fraction),
    #: and the encoder when it was last advanced
    stop_rate: int
    stop_lead: int
    stop_integral: int
    stop_encoder: int
    #: BrakeCommand as last heard, BrakeState, ticks since it was to close
    brake_command: int
    brake_state: int
    brake_age: int
    #: whether the winding is shorted
    shorted: int
    #: see `runaway`: torque times ticks (fraction), twice, then torque, then whether the axis ran away
    momentum: int
    effort: int
    peak_torque: int
    ran_away: int
    # --- settings
    has_brake: int
    #: of two, by which a raw torque counts more than TORQUE_STEP_NM
    exponent: int
    torque_limit: int
    travel_low: int
    travel_high: int
    rate_limit: int
    overspeed: int
    max_winding: int
    #: torque per rate, per count, and per count and tick (fractions); deceleration in rate per tick
    stop_rate_gain: int
    stop_position_gain: int
    stop_integral_gain: int
    stop_rate_per_tick: int
    #: torque times ticks for a rate of one (fraction), most impulse that is not the motor's, 0 for no guard
    impulse_of_rate: int
    strange_impulse: int
    # --- faults given on purpose
    encoder_spoilt: Fault
    gyro_spoilt: Fault
    motor_spoilt: Fault


class Drive(MemoryRecord):
    """What the firmware keeps of the whole drive."""

    # --- state
    #: DriveState, ticks in it; latched FaultCode and what it is about; the tick of the last sample
    state: int
    state_age: int
    fault: int
    fault_detail: int
    tick: int
    #: set-point: sequence of the last one taken (NO_SEQUENCE before the first), ticks left before the deadman reacts,
    #: fresh ones taken, repeats refused
    last_sequence: int
    margin: int
    taken: int
    refused: int
    #: deadman: window in ticks, StopReaction; what the drive does in this fault reaction
    window: int
    reaction: int
    active_reaction: int
    #: drive_control: level of fault_reset when last heard, ticks since heard, whether torque that leads back from a
    #: travel limit is allowed
    reset_level: int
    control_age: int
    travel_cleared: int
    #: ticks in a row at rest while stopping; limits that act now; supply voltage as measured
    rest_count: int
    limits: int
    supply: int
    #: attitude as sampled with the last base_attitude, until base_heading has told the rest: raw yaw, tick and
    #: fraction of it (1 / 256) at which it was true
    yaw: int
    attitude_tick: int
    attitude_fraction: int
    # --- settings
    startup_ticks: int
    control_silence_ticks: int
    travel_reaction: int
    fault_reaction: int
    min_supply: int
    rest_rate: int
    rest_ticks: int
    hold_ticks: int
    reaction_ticks: int
    #: raw rate of one count a tick (fraction), counts a tick of a raw rate of one (fraction)
    rate_of_count: int
    count_of_rate: int
    #: ticks that a holding brake takes to close; who the antenna is: code of its name, serial number
    brake_ticks: int
    name_code: int
    serial_number: int
    #: raw rates by which encoder and gyro may differ: more is a fault; more than the second, and no stop relies on
    #: either
    max_disagreement: int
    stop_disagreement: int
    #: share of momentum that is remembered from tick to tick (fraction)
    momentum_kept: int
    joints: Annotated[Sequence[Joint], 2]


DRIVE = layout_of(Drive)
DRIVE_WORDS = DRIVE.itemsize // 8

SCALE_BITS = 16
SCALE = 1 << SCALE_BITS
#: the joint rate takes over 1 / 2^2 of each new difference
JOINT_RATE_SHIFT = 2

#: `detail` of a drive_event whose cause is NONE: the request that was granted (DriveRequest), or one of these; of a
#: fault: the axis
DETAIL_BY_ITSELF, DETAIL_FAULT_RESET = 0, 7
#: the last sequence that a drive reports before its first set-point: the one before sequence 0
NO_SEQUENCE = -1
