"""The memory of the C device as Python sees it: the structures of `firmware_protocol/c`, field by field.

A test holds sizes and offsets to what the compiler says.
"""

from __future__ import annotations

import ctypes
from ctypes import c_bool, c_int32, c_int64, c_uint8, c_uint16, c_uint32, c_void_p
from typing import Any

AXES, PACKET_LIMIT, SEALED_LIMIT, MOST_SENT = 2, 484, 482, 160
HEARD, SAID = 3, 12


class CAxisSettings(ctypes.Structure):
    """gimbal_axis_settings_t"""

    _fields_ = (
        *((name, c_int32) for name in ("has_brake", "exponent", "torque_limit", "travel_low", "travel_high")),
        *((name, c_int32) for name in ("rate_limit", "overspeed", "max_winding")),
        *((name, c_int64) for name in ("stop_rate_gain", "stop_position_gain", "stop_integral_gain")),
        ("stop_rate_per_tick", c_int32),
        ("impulse_of_rate", c_int64),
        ("strange_impulse", c_int64),
    )


class CSettings(ctypes.Structure):
    """gimbal_settings_t"""

    _fields_ = (
        *((name, c_int32) for name in ("axes", "startup_ticks", "control_silence_ticks", "travel_reaction")),
        *((name, c_int32) for name in ("fault_reaction", "min_supply", "rest_rate", "rest_ticks", "hold_ticks")),
        ("reaction_ticks", c_int32),
        ("rate_of_count", c_int64),
        ("count_of_rate", c_int64),
        *((name, c_int32) for name in ("brake_ticks", "name_code", "serial_number", "max_disagreement")),
        ("stop_disagreement", c_int32),
        ("momentum_kept", c_int64),
        ("deadman_window", c_int32),
        ("deadman_reaction", c_int32),
        ("joints", CAxisSettings * AXES),
    )


class CJoint(ctypes.Structure):
    """gimbal_joint_t"""

    _fields_ = (
        *((name, c_int32) for name in ("set_torque", "set_enable", "applied_torque", "encoder", "gyro")),
        ("joint_rate", c_int64),
        ("winding", c_int32),
        ("sensor_fault", c_int32),
        *((name, c_int64) for name in ("stop_rate", "stop_lead", "stop_integral")),
        ("stop_encoder", c_int32),
        *((name, c_int32) for name in ("brake_command", "brake_state", "brake_age", "shorted")),
        *((name, c_int64) for name in ("momentum", "effort", "peak_torque")),
        ("ran_away", c_int32),
        ("motor_torque", c_int32),
    )


class CDrive(ctypes.Structure):
    """gimbal_drive_t"""

    _fields_ = (
        *((name, c_int32) for name in ("state", "state_age", "fault", "fault_detail")),
        ("tick", c_uint32),
        ("last_sequence", c_int32),
        ("margin", c_int32),
        ("taken", c_uint32),
        ("refused", c_uint32),
        *((name, c_int32) for name in ("window", "reaction", "active_reaction", "reset_level", "control_age")),
        *((name, c_int32) for name in ("travel_cleared", "rest_count", "limits", "supply", "yaw", "attitude_tick")),
        ("joints", CJoint * AXES),
    )


class CActuation(ctypes.Structure):
    """gimbal_actuation_t"""

    _fields_ = (("torque", c_int32), ("powered", c_bool), ("shorted", c_bool), ("brake_held", c_bool))


class CSample(ctypes.Structure):
    """gimbal_sample_t"""

    _fields_ = (*((name, c_int32) for name in ("position", "rate", "torque", "winding")), ("valid", c_bool))


class CBase(ctypes.Structure):
    """gimbal_base_t"""

    _fields_ = tuple((name, c_int32) for name in ("roll", "pitch", "yaw", "p", "q", "r", "ax", "ay", "az"))


class CReceiver(ctypes.Structure):
    """gimbal_receiver_t"""

    _fields_ = (
        ("last_counter", c_int32),
        *((name, c_uint32) for name in ("ticks_since_good", "good", "crc_errors", "out_of_range", "duplicates")),
        ("lost_frames", c_uint32),
    )


class CControl(ctypes.Structure):
    """gimbal_drive_control_t"""

    _fields_ = (
        ("request", c_uint8),
        *((name, c_bool) for name in ("fault_reset", "quick_stop", "clear_travel")),
        *((name, c_uint8) for name in ("stop", "brake_outer", "brake_inner")),
        ("identify", c_bool),
    )


class CSetPoint(ctypes.Structure):
    """gimbal_set_point_t"""

    _fields_ = (
        ("torque_outer", c_int32),
        ("torque_inner", c_int32),
        ("sequence", c_uint16),
        ("enable_outer", c_bool),
        ("enable_inner", c_bool),
    )


class CDeadman(ctypes.Structure):
    """gimbal_deadman_config_t"""

    _fields_ = (("window_ticks", c_uint8), ("reaction", c_uint8))


class CEvent(ctypes.Structure):
    """gimbal_drive_event_t"""

    _fields_ = (
        *((name, c_uint8) for name in ("from_state", "to_state", "cause", "detail")),
        ("tick", c_uint16),
    )


def bench_of(pointer: type) -> type[ctypes.Structure]:
    """gimbal_bench_t with pointers of this width: the machine's own, or 32 bits of a microcontroller."""

    class CDevice(ctypes.Structure):
        """gimbal_device_t"""

        _fields_ = (
            ("settings", pointer),
            ("hardware", pointer),
            ("drive", CDrive),
            ("fresh", c_bool * HEARD),
            ("control", CControl),
            ("set_point", CSetPoint),
            ("deadman", CDeadman),
            ("has_event", c_bool),
            ("event", CEvent),
            ("receivers", CReceiver * HEARD),
            ("stray_frames", c_uint32),
            ("counters", c_uint8 * SAID),
        )

    class CHardware(ctypes.Structure):
        """gimbal_hardware_t"""

        _fields_ = tuple((name, pointer) for name in ("context", "supply", "actuate", "sample", "base", "send"))

    class CStream(ctypes.Structure):
        """gimbal_stream_t"""

        _fields_ = (
            ("packet", c_uint8 * PACKET_LIMIT),
            ("size", c_uint32),
            ("overflowed", c_bool),
            *((name, c_uint32) for name in ("packets", "bad_coding", "bad_crc", "bad_length", "too_long")),
        )

    class CPacket(ctypes.Structure):
        """gimbal_packet_t"""

        _fields_ = (
            ("sealed", c_uint8 * SEALED_LIMIT),
            ("size", c_uint32),
            ("packet", c_uint8 * (PACKET_LIMIT + 1)),
        )

    class CBench(ctypes.Structure):
        """gimbal_bench_t"""

        _fields_ = (
            ("device", CDevice),
            ("settings", CSettings),
            ("hardware", CHardware),
            ("wanted", CActuation * AXES),
            ("samples", CSample * AXES),
            ("base", CBase),
            ("supply", c_int32),
            ("advance", pointer),
            ("sent", c_uint8 * MOST_SENT),
            ("sent_size", c_uint32),
            ("stream", CStream),
            ("packet", CPacket),
        )

    return CBench


#: of a library in this process
HostBench = bench_of(c_void_p)
#: of a microcontroller with 32 bits
SmallBench = bench_of(c_uint32)
#: gimbal_device_t of one
SmallDevice: Any = SmallBench._fields_[0][1]
