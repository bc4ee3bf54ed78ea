"""Field words from mail slots and back, every shift and bound a literal.

Emitted from `schema` by `gimbal-hil protocol --emit field_words`; do not edit. One expression per field, because each call of a small
compiled function with other literals would be compiled anew; every branch returns, because then only one is computed. The table-driven
`codec` is the independent second reading of the schema that the tests hold this one against.
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
        return word
    if message == 1:  # set_point
        word |= (min(max(mail[6], -131072), 131071) & 0x3FFFF) << 0
        word |= (min(max(mail[7], -131072), 131071) & 0x3FFFF) << 18
        word |= (min(max(mail[8], 0), 1023) & 0x3FF) << 36
        word |= (min(max(mail[9], 0), 1) & 0x1) << 46
        word |= (min(max(mail[10], 0), 1) & 0x1) << 47
        return word
    if message == 2:  # deadman_config
        word |= (min(max(mail[12], 1), 255) & 0xFF) << 0
        word |= (min(max(mail[13], 0), 2) & 0x3) << 8
        return word
    if message == 3:  # feedback_outer
        word |= (min(max(mail[15], -33554432), 33554431) & 0x3FFFFFF) << 0
        word |= (min(max(mail[16], -2097152), 2097151) & 0x3FFFFF) << 26
        return word
    if message == 4:  # feedback_inner
        word |= (min(max(mail[18], -33554432), 33554431) & 0x3FFFFFF) << 0
        word |= (min(max(mail[19], -2097152), 2097151) & 0x3FFFFF) << 26
        return word
    if message == 5:  # drive_status
        word |= (min(max(mail[21], 0), 7) & 0xF) << 0
        word |= (min(max(mail[22], 0), 9) & 0x3F) << 4
        word |= (min(max(mail[23], 0), 1023) & 0x3FF) << 10
        word |= (min(max(mail[24], 0), 255) & 0xFF) << 20
        word |= (min(max(mail[25], 0), 255) & 0xFF) << 28
        word |= (min(max(mail[26], 0), 4095) & 0xFFF) << 36
        return word
    if message == 6:  # motor_status_outer
        word |= (min(max(mail[28], -131072), 131071) & 0x3FFFF) << 0
        word |= (min(max(mail[29], -2048), 2047) & 0xFFF) << 18
        word |= (min(max(mail[30], 0), 4095) & 0xFFF) << 30
        return word
    if message == 7:  # motor_status_inner
        word |= (min(max(mail[32], -131072), 131071) & 0x3FFFF) << 0
        word |= (min(max(mail[33], -2048), 2047) & 0xFFF) << 18
        word |= (min(max(mail[34], 0), 4095) & 0xFFF) << 30
        return word
    if message == 8:  # base_attitude
        word |= (min(max(mail[36], -32768), 32767) & 0xFFFF) << 0
        word |= (min(max(mail[37], -32768), 32767) & 0xFFFF) << 16
        word |= (min(max(mail[38], -32768), 32767) & 0xFFFF) << 32
        return word
    if message == 9:  # base_rate
        word |= (min(max(mail[40], -32768), 32767) & 0xFFFF) << 0
        word |= (min(max(mail[41], -32768), 32767) & 0xFFFF) << 16
        word |= (min(max(mail[42], -32768), 32767) & 0xFFFF) << 32
        return word
    if message == 10:  # drive_event
        word |= (min(max(mail[44], 0), 7) & 0xF) << 0
        word |= (min(max(mail[45], 0), 7) & 0xF) << 4
        word |= (min(max(mail[46], 0), 9) & 0x3F) << 8
        word |= (min(max(mail[47], 0), 255) & 0xFF) << 14
        word |= (min(max(mail[48], 0), 4095) & 0xFFF) << 22
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
        if request > 6:
            return False
        mail[1] = request
        mail[2] = fault_reset
        mail[3] = quick_stop
        mail[4] = clear_travel
        return True
    if message == 1:  # set_point
        torque_outer = (word >> 0) & 0x3FFFF
        torque_outer -= (torque_outer & 0x20000) << 1
        torque_inner = (word >> 18) & 0x3FFFF
        torque_inner -= (torque_inner & 0x20000) << 1
        sequence = (word >> 36) & 0x3FF
        enable_outer = (word >> 46) & 0x1
        enable_inner = (word >> 47) & 0x1
        mail[6] = torque_outer
        mail[7] = torque_inner
        mail[8] = sequence
        mail[9] = enable_outer
        mail[10] = enable_inner
        return True
    if message == 2:  # deadman_config
        window_ticks = (word >> 0) & 0xFF
        reaction = (word >> 8) & 0x3
        if window_ticks < 1 or reaction > 2:
            return False
        mail[12] = window_ticks
        mail[13] = reaction
        return True
    if message == 3:  # feedback_outer
        position = (word >> 0) & 0x3FFFFFF
        position -= (position & 0x2000000) << 1
        rate = (word >> 26) & 0x3FFFFF
        rate -= (rate & 0x200000) << 1
        mail[15] = position
        mail[16] = rate
        return True
    if message == 4:  # feedback_inner
        position = (word >> 0) & 0x3FFFFFF
        position -= (position & 0x2000000) << 1
        rate = (word >> 26) & 0x3FFFFF
        rate -= (rate & 0x200000) << 1
        mail[18] = position
        mail[19] = rate
        return True
    if message == 5:  # drive_status
        state = (word >> 0) & 0xF
        fault = (word >> 4) & 0x3F
        last_sequence = (word >> 10) & 0x3FF
        deadman_margin = (word >> 20) & 0xFF
        limits = (word >> 28) & 0xFF
        tick = (word >> 36) & 0xFFF
        if state > 7 or fault > 9:
            return False
        mail[21] = state
        mail[22] = fault
        mail[23] = last_sequence
        mail[24] = deadman_margin
        mail[25] = limits
        mail[26] = tick
        return True
    if message == 6:  # motor_status_outer
        torque = (word >> 0) & 0x3FFFF
        torque -= (torque & 0x20000) << 1
        temperature = (word >> 18) & 0xFFF
        temperature -= (temperature & 0x800) << 1
        supply = (word >> 30) & 0xFFF
        mail[28] = torque
        mail[29] = temperature
        mail[30] = supply
        return True
    if message == 7:  # motor_status_inner
        torque = (word >> 0) & 0x3FFFF
        torque -= (torque & 0x20000) << 1
        temperature = (word >> 18) & 0xFFF
        temperature -= (temperature & 0x800) << 1
        supply = (word >> 30) & 0xFFF
        mail[32] = torque
        mail[33] = temperature
        mail[34] = supply
        return True
    if message == 8:  # base_attitude
        roll = (word >> 0) & 0xFFFF
        roll -= (roll & 0x8000) << 1
        pitch = (word >> 16) & 0xFFFF
        pitch -= (pitch & 0x8000) << 1
        yaw = (word >> 32) & 0xFFFF
        yaw -= (yaw & 0x8000) << 1
        mail[36] = roll
        mail[37] = pitch
        mail[38] = yaw
        return True
    if message == 9:  # base_rate
        p = (word >> 0) & 0xFFFF
        p -= (p & 0x8000) << 1
        q = (word >> 16) & 0xFFFF
        q -= (q & 0x8000) << 1
        r = (word >> 32) & 0xFFFF
        r -= (r & 0x8000) << 1
        mail[40] = p
        mail[41] = q
        mail[42] = r
        return True
    if message == 10:  # drive_event
        from_state = (word >> 0) & 0xF
        to_state = (word >> 4) & 0xF
        cause = (word >> 8) & 0x3F
        detail = (word >> 14) & 0xFF
        tick = (word >> 22) & 0xFFF
        if from_state > 7 or to_state > 7 or cause > 9:
            return False
        mail[44] = from_state
        mail[45] = to_state
        mail[46] = cause
        mail[47] = detail
        mail[48] = tick
        return True
    return False
