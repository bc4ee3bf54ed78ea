"""Field words from mail slots and back, every shift and bound a literal.

Emitted from `schema` by `gimbal-hil protocol --emit field_words`; do not edit. One expression per field, because each
call of a small compiled function with other literals would be compiled anew; every branch returns, because then only
one is computed. The table-driven `codec` reads the schema independently, and the tests hold this one against it.
"""

from __future__ import annotations

from firmware_protocol.leaves import leaf
from firmware_protocol.words import Slots


@leaf
def pack(message: int, mail: Slots) -> int:
    """Field word of the message with that index; values held at their bounds."""
    word = 0
    if message == 0:  # drive_control
        word |= (min(max(mail[1], 0), 6) & 0xF) << 0
        word |= (min(max(mail[2], 0), 1) & 0x1) << 4
        word |= (min(max(mail[3], 0), 1) & 0x1) << 5
        word |= (min(max(mail[4], 0), 1) & 0x1) << 6
        word |= (min(max(mail[5], 0), 3) & 0x7) << 7
        word |= (min(max(mail[6], 0), 2) & 0x3) << 10
        word |= (min(max(mail[7], 0), 2) & 0x3) << 12
        word |= (min(max(mail[8], 0), 1) & 0x1) << 14
        return word
    if message == 1:  # set_point
        word |= (min(max(mail[10], -131072), 131071) & 0x3FFFF) << 0
        word |= (min(max(mail[11], -131072), 131071) & 0x3FFFF) << 18
        word |= (min(max(mail[12], 0), 1023) & 0x3FF) << 36
        word |= (min(max(mail[13], 0), 1) & 0x1) << 46
        word |= (min(max(mail[14], 0), 1) & 0x1) << 47
        return word
    if message == 2:  # deadman_config
        word |= (min(max(mail[16], 1), 255) & 0xFF) << 0
        word |= (min(max(mail[17], 0), 3) & 0x7) << 8
        return word
    if message == 3:  # feedback_outer
        word |= (min(max(mail[19], -33554432), 33554431) & 0x3FFFFFF) << 0
        word |= (min(max(mail[20], -2097152), 2097151) & 0x3FFFFF) << 26
        return word
    if message == 4:  # feedback_inner
        word |= (min(max(mail[22], -33554432), 33554431) & 0x3FFFFFF) << 0
        word |= (min(max(mail[23], -2097152), 2097151) & 0x3FFFFF) << 26
        return word
    if message == 5:  # drive_status
        word |= (min(max(mail[25], 0), 7) & 0xF) << 0
        word |= (min(max(mail[26], 0), 13) & 0x3F) << 4
        word |= (min(max(mail[27], 0), 1023) & 0x3FF) << 10
        word |= (min(max(mail[28], 0), 255) & 0xFF) << 20
        word |= (min(max(mail[29], 0), 255) & 0xFF) << 28
        word |= (min(max(mail[30], 0), 4095) & 0xFFF) << 36
        return word
    if message == 6:  # motor_status_outer
        word |= (min(max(mail[32], -131072), 131071) & 0x3FFFF) << 0
        word |= (min(max(mail[33], -2048), 2047) & 0xFFF) << 18
        word |= (min(max(mail[34], 0), 4095) & 0xFFF) << 30
        word |= (min(max(mail[35], 0), 2) & 0x3) << 42
        word |= (min(max(mail[36], 0), 1) & 0x1) << 44
        return word
    if message == 7:  # motor_status_inner
        word |= (min(max(mail[38], -131072), 131071) & 0x3FFFF) << 0
        word |= (min(max(mail[39], -2048), 2047) & 0xFFF) << 18
        word |= (min(max(mail[40], 0), 4095) & 0xFFF) << 30
        word |= (min(max(mail[41], 0), 2) & 0x3) << 42
        word |= (min(max(mail[42], 0), 1) & 0x1) << 44
        return word
    if message == 8:  # base_attitude
        word |= (min(max(mail[44], -2097152), 2097151) & 0x3FFFFF) << 0
        word |= (min(max(mail[45], -2097152), 2097151) & 0x3FFFFF) << 22
        word |= (min(max(mail[46], 0), 15) & 0xF) << 44
        return word
    if message == 9:  # base_rate
        word |= (min(max(mail[48], -32768), 32767) & 0xFFFF) << 0
        word |= (min(max(mail[49], -32768), 32767) & 0xFFFF) << 16
        word |= (min(max(mail[50], -32768), 32767) & 0xFFFF) << 32
        return word
    if message == 10:  # drive_event
        word |= (min(max(mail[52], 0), 7) & 0xF) << 0
        word |= (min(max(mail[53], 0), 7) & 0xF) << 4
        word |= (min(max(mail[54], 0), 13) & 0x3F) << 8
        word |= (min(max(mail[55], 0), 255) & 0xFF) << 14
        word |= (min(max(mail[56], 0), 4095) & 0xFFF) << 22
        return word
    if message == 11:  # base_heading
        word |= (min(max(mail[58], -2097152), 2097151) & 0x3FFFFF) << 0
        word |= (min(max(mail[59], 0), 4095) & 0xFFF) << 22
        word |= (min(max(mail[60], 0), 255) & 0xFF) << 34
        return word
    if message == 12:  # base_acceleration
        word |= (min(max(mail[62], -32768), 32767) & 0xFFFF) << 0
        word |= (min(max(mail[63], -32768), 32767) & 0xFFFF) << 16
        word |= (min(max(mail[64], -32768), 32767) & 0xFFFF) << 32
        return word
    if message == 13:  # identity
        word |= (min(max(mail[66], 0), 255) & 0xFF) << 0
        word |= (min(max(mail[67], 0), 2147483647) & 0x7FFFFFFF) << 8
        word |= (min(max(mail[68], 0), 1) & 0x1) << 39
        word |= (min(max(mail[69], 0), 1) & 0x1) << 40
        return word
    if message == 14:  # identity_unit
        word |= (min(max(mail[71], 0), 2147483647) & 0x7FFFFFFF) << 0
        word |= (min(max(mail[72], 0), 31) & 0x1F) << 31
        word |= (min(max(mail[73], 0), 31) & 0x1F) << 36
        return word
    return word


@leaf
def unpack(message: int, word: int, mail: Slots) -> bool:
    """Field word into the mail; False, and nothing written, when a field is out of bounds."""
    if message == 0:  # drive_control
        request = (word >> 0) & 0xF
        fault_reset = (word >> 4) & 0x1
        quick_stop = (word >> 5) & 0x1
        clear_travel = (word >> 6) & 0x1
        stop = (word >> 7) & 0x7
        brake_outer = (word >> 10) & 0x3
        brake_inner = (word >> 12) & 0x3
        identify = (word >> 14) & 0x1
        if request > 6 or stop > 3 or brake_outer > 2 or brake_inner > 2:
            return False
        mail[1] = request
        mail[2] = fault_reset
        mail[3] = quick_stop
        mail[4] = clear_travel
        mail[5] = stop
        mail[6] = brake_outer
        mail[7] = brake_inner
        mail[8] = identify
        return True
    if message == 1:  # set_point
        torque_outer = (word >> 0) & 0x3FFFF
        torque_outer -= (torque_outer & 0x20000) << 1
        torque_inner = (word >> 18) & 0x3FFFF
        torque_inner -= (torque_inner & 0x20000) << 1
        sequence = (word >> 36) & 0x3FF
        enable_outer = (word >> 46) & 0x1
        enable_inner = (word >> 47) & 0x1
        mail[10] = torque_outer
        mail[11] = torque_inner
        mail[12] = sequence
        mail[13] = enable_outer
        mail[14] = enable_inner
        return True
    if message == 2:  # deadman_config
        window_ticks = (word >> 0) & 0xFF
        reaction = (word >> 8) & 0x7
        if window_ticks < 1 or reaction > 3:
            return False
        mail[16] = window_ticks
        mail[17] = reaction
        return True
    if message == 3:  # feedback_outer
        position = (word >> 0) & 0x3FFFFFF
        position -= (position & 0x2000000) << 1
        rate = (word >> 26) & 0x3FFFFF
        rate -= (rate & 0x200000) << 1
        mail[19] = position
        mail[20] = rate
        return True
    if message == 4:  # feedback_inner
        position = (word >> 0) & 0x3FFFFFF
        position -= (position & 0x2000000) << 1
        rate = (word >> 26) & 0x3FFFFF
        rate -= (rate & 0x200000) << 1
        mail[22] = position
        mail[23] = rate
        return True
    if message == 5:  # drive_status
        state = (word >> 0) & 0xF
        fault = (word >> 4) & 0x3F
        last_sequence = (word >> 10) & 0x3FF
        deadman_margin = (word >> 20) & 0xFF
        limits = (word >> 28) & 0xFF
        tick = (word >> 36) & 0xFFF
        if state > 7 or fault > 13:
            return False
        mail[25] = state
        mail[26] = fault
        mail[27] = last_sequence
        mail[28] = deadman_margin
        mail[29] = limits
        mail[30] = tick
        return True
    if message == 6:  # motor_status_outer
        torque = (word >> 0) & 0x3FFFF
        torque -= (torque & 0x20000) << 1
        temperature = (word >> 18) & 0xFFF
        temperature -= (temperature & 0x800) << 1
        supply = (word >> 30) & 0xFFF
        brake = (word >> 42) & 0x3
        shorted = (word >> 44) & 0x1
        if brake > 2:
            return False
        mail[32] = torque
        mail[33] = temperature
        mail[34] = supply
        mail[35] = brake
        mail[36] = shorted
        return True
    if message == 7:  # motor_status_inner
        torque = (word >> 0) & 0x3FFFF
        torque -= (torque & 0x20000) << 1
        temperature = (word >> 18) & 0xFFF
        temperature -= (temperature & 0x800) << 1
        supply = (word >> 30) & 0xFFF
        brake = (word >> 42) & 0x3
        shorted = (word >> 44) & 0x1
        if brake > 2:
            return False
        mail[38] = torque
        mail[39] = temperature
        mail[40] = supply
        mail[41] = brake
        mail[42] = shorted
        return True
    if message == 8:  # base_attitude
        roll = (word >> 0) & 0x3FFFFF
        roll -= (roll & 0x200000) << 1
        pitch = (word >> 22) & 0x3FFFFF
        pitch -= (pitch & 0x200000) << 1
        set = (word >> 44) & 0xF
        mail[44] = roll
        mail[45] = pitch
        mail[46] = set
        return True
    if message == 9:  # base_rate
        p = (word >> 0) & 0xFFFF
        p -= (p & 0x8000) << 1
        q = (word >> 16) & 0xFFFF
        q -= (q & 0x8000) << 1
        r = (word >> 32) & 0xFFFF
        r -= (r & 0x8000) << 1
        mail[48] = p
        mail[49] = q
        mail[50] = r
        return True
    if message == 10:  # drive_event
        from_state = (word >> 0) & 0xF
        to_state = (word >> 4) & 0xF
        cause = (word >> 8) & 0x3F
        detail = (word >> 14) & 0xFF
        tick = (word >> 22) & 0xFFF
        if from_state > 7 or to_state > 7 or cause > 13:
            return False
        mail[52] = from_state
        mail[53] = to_state
        mail[54] = cause
        mail[55] = detail
        mail[56] = tick
        return True
    if message == 11:  # base_heading
        yaw = (word >> 0) & 0x3FFFFF
        yaw -= (yaw & 0x200000) << 1
        valid_tick = (word >> 22) & 0xFFF
        valid_fraction = (word >> 34) & 0xFF
        mail[58] = yaw
        mail[59] = valid_tick
        mail[60] = valid_fraction
        return True
    if message == 12:  # base_acceleration
        ax = (word >> 0) & 0xFFFF
        ax -= (ax & 0x8000) << 1
        ay = (word >> 16) & 0xFFFF
        ay -= (ay & 0x8000) << 1
        az = (word >> 32) & 0xFFFF
        az -= (az & 0x8000) << 1
        mail[62] = ax
        mail[63] = ay
        mail[64] = az
        return True
    if message == 13:  # identity
        protocol_version = (word >> 0) & 0xFF
        name = (word >> 8) & 0x7FFFFFFF
        has_brake_outer = (word >> 39) & 0x1
        has_brake_inner = (word >> 40) & 0x1
        mail[66] = protocol_version
        mail[67] = name
        mail[68] = has_brake_outer
        mail[69] = has_brake_inner
        return True
    if message == 14:  # identity_unit
        serial_number = (word >> 0) & 0x7FFFFFFF
        torque_exponent_outer = (word >> 31) & 0x1F
        torque_exponent_inner = (word >> 36) & 0x1F
        mail[71] = serial_number
        mail[72] = torque_exponent_outer
        mail[73] = torque_exponent_inner
        return True
    return False
