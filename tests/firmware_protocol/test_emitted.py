"""What is kept in the tree is what the schema emits, and other people's tools read the same numbers from it."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import cantools
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol import codec, mail
from firmware_protocol.emit import FORMS, committed_path, emit
from firmware_protocol.emit.dbc import field_text
from firmware_protocol.enumerations import ENUMERATIONS
from firmware_protocol.messages import CLASSES
from firmware_protocol.schema import BY_CAN_ID, FIELD_BITS, INDEX, MAIL_SIZE, MESSAGES, Direction, Message, offset

DATABASE = cantools.database.load_file(committed_path("dbc"))


def drawn(message: Message) -> st.SearchStrategy[tuple[int, ...]]:
    return st.tuples(*(st.integers(field.raw_low, field.raw_high) for field in message.fields))


@pytest.mark.parametrize("form", FORMS)
def test_the_kept_file_is_what_the_schema_emits(form):
    assert committed_path(form).read_text() == emit(form)


def test_every_message_fits_its_frame_and_every_identifier_and_data_id_is_its_own():
    assert all(sum(field.bits for field in message.fields) <= FIELD_BITS for message in MESSAGES)
    assert len(BY_CAN_ID) == len({message.data_id for message in MESSAGES}) == len(MESSAGES)
    assert all(0 < message.data_id < 256 and message.can_id < 2048 for message in MESSAGES)


def test_what_the_host_sends_wins_the_bus_and_the_set_point_comes_before_feedback():
    highest_host = max(message.can_id for message in MESSAGES if message.direction is Direction.HOST_TO_DEVICE)
    assert all(message.can_id > highest_host for message in MESSAGES if message.direction is Direction.DEVICE_TO_HOST)


def test_the_resolution_is_what_the_physics_needs():
    fields = {(message.name, field.name): field for message in MESSAGES for field in message.fields}
    for axis in ("outer", "inner"):
        position, rate = fields[f"feedback_{axis}", "position"], fields[f"feedback_{axis}", "rate"]
        torque = fields["set_point", f"torque_{axis}"]
        assert position.step <= 1.5e-6 and position.raw_high * position.step > 2 * 6.3
        assert rate.step <= 1e-5 and rate.raw_high * rate.step >= 15 and rate.raw_low * rate.step <= -15
        assert torque.step <= 0.2e-3 and torque.raw_high * torque.step >= 16 and torque.raw_low * torque.step <= -16


def test_the_mail_constants_are_the_layout_of_the_schema():
    assert mail.MAIL_SIZE == MAIL_SIZE
    for message in MESSAGES:
        name = message.name.upper()
        assert getattr(mail, name) == offset(message.name)
        assert getattr(mail, f"{name}_MESSAGE") == INDEX[message.name]
        for place, field in enumerate(message.fields, start=1):
            assert getattr(mail, f"{name}_{field.name.upper()}") == offset(message.name) + place


@given(
    st.sampled_from(MESSAGES).flatmap(lambda message: st.tuples(st.just(message), drawn(message))), st.integers(0, 15)
)
@settings(max_examples=300, deadline=None)
def test_cantools_decodes_every_frame_to_the_same_numbers(sent, counter):
    message, raw = sent
    payload = codec.pack_raw(message, raw, counter)
    typed = codec.from_raw(message, raw)
    decoded = DATABASE.decode_message(message.can_id, payload, decode_choices=False)
    seal = {name: decoded.pop(name) for name in ("alive_counter", "crc")}
    assert seal == {"alive_counter": counter, "crc": int.from_bytes(payload, "little") >> 52}
    assert decoded == {field.name: getattr(typed, field.attribute) for field in message.fields}
    assert DATABASE.encode_message(message.can_id, {**decoded, **seal}) == payload


def test_cantools_knows_the_names_of_states_the_comments_and_the_cycle_times():
    for message in MESSAGES:
        theirs = DATABASE.get_message_by_frame_id(message.can_id)
        assert theirs.name == message.name and theirs.comment == message.text and theirs.length == 8
        assert (theirs.cycle_time or 0) == message.period_ticks
        assert theirs.dbc.attributes["DataId"].value == message.data_id
        for field in message.fields:
            signal = theirs.get_signal_by_name(field.name)
            assert signal.comment == field_text(field)
            assert (signal.unit or "") == field.unit
            if field.enum is not None:
                assert {int(value): str(name) for value, name in signal.choices.items()} == {
                    int(each): each.name for each in field.enum
                }


def test_every_dataclass_has_the_fields_of_its_message():
    for message in MESSAGES:
        assert list(CLASSES[message.name].__slots__) == [field.attribute for field in message.fields]


C_MAIN = """
#include <stdio.h>
#include "gimbal_protocol.h"

static void show(const uint8_t payload[8])
{
    for (int place = 0; place < 8; ++place)
        printf("%02x", payload[place]);
    printf(" ");
}

int main(void)
{
    uint16_t crc = 0;
    for (const char *digit = "123456789"; *digit; ++digit)
        crc = gimbal_crc12_byte(crc, (uint8_t)*digit);
    printf("%03x\\n", crc);
%CASES%
    return 0;
}
"""


def c_case(message: Message, raw: tuple[int, ...], counter: int) -> str:
    """One message packed, shown, unpacked, shown, and refused after a flipped bit."""
    members = ", ".join(f".{field.name} = {number}" for field, number in zip(message.fields, raw, strict=True))
    shown = "".join(f' printf("%ld ", (long)back.{field.name});' for field in message.fields)
    return f"""    {{
        const gimbal_{message.name}_t sent = {{{members}}};
        gimbal_{message.name}_t back;
        uint8_t payload[8];
        gimbal_{message.name}_pack(&sent, {counter}, payload);
        show(payload);
        if (!gimbal_{message.name}_unpack(payload, &back) || gimbal_alive_counter(payload) != {counter})
            return 1;
       {shown}
        payload[{counter % 8}] ^= 4;
        if (gimbal_{message.name}_unpack(payload, &back))
            return 2;
        printf("\\n");
    }}"""


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler here")
def test_firmware_that_uses_the_c_header_makes_and_reads_the_same_frames(tmp_path):
    cases = []
    for message in MESSAGES:
        lows, highs = [tuple(getattr(field, bound) for field in message.fields) for bound in ("raw_low", "raw_high")]
        middles = tuple((low + 2 * high) // 3 for low, high in zip(lows, highs, strict=True))
        cases += [(message, raw, counter) for counter, raw in enumerate((lows, highs, middles), start=5)]
    source, program = tmp_path / "main.c", tmp_path / "main"
    source.write_text(C_MAIN.replace("%CASES%", "\n".join(c_case(*case) for case in cases)))
    strict = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror"]
    subprocess.run(["cc", *strict, f"-I{committed_path('c').parent}", str(source), "-o", str(program)], check=True)
    first, *lines = subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout.splitlines()
    assert first == "6dd"
    for (message, raw, counter), line in zip(cases, lines, strict=True):
        payload, *numbers = line.split()
        assert payload == codec.pack_raw(message, raw, counter).hex()
        assert tuple(map(int, numbers)) == raw


def test_the_documentation_names_every_message_field_and_enumeration_member():
    page = committed_path("docs").read_text()
    for message in MESSAGES:
        assert f"`{message.name}` 0x{message.can_id:03X}" in page
        assert all(f"`{field.name}`" in page for field in message.fields)
    for enumeration in ENUMERATIONS:
        assert all(f"{int(member.value)} `{member.name}`" in page for member in enumeration)
    assert "59.7%" in page


def run_protocol(*arguments: str) -> int:
    from gimbal_hil.surface.cli.app import run

    return run("protocol", list(arguments))


def test_the_command_prints_writes_and_checks(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert run_protocol("--emit", "dbc") == 0
    assert capsys.readouterr().out == emit("dbc")
    target = tmp_path / "antenna.h"
    assert run_protocol("--emit", "c", "--out", str(target)) == 0
    assert run_protocol("--emit", "c", "--out", str(target), "--check") == 0
    assert run_protocol("--check") == 0
    target.write_text(target.read_text().replace("0x75D", "0x75C"))
    assert run_protocol("--emit", "c", "--out", str(target), "--check") == 1
    assert "differs from line" in capsys.readouterr().out
    assert run_protocol("--emit", "c", "--out", str(target), "--force") == 0
    assert target.read_text() == emit("c")


@pytest.mark.parametrize(
    "arguments", [["--emit", "svg"], [], ["--check", "--out", "x"], ["--emit", "dbc", "--out", "/no such folder/x"]]
)
def test_the_command_refuses_wrong_use_in_one_line(arguments, capsys):
    with pytest.raises(SystemExit) as ended:
        run_protocol(*arguments)
    assert ended.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_the_command_never_overwrites_unasked(tmp_path, capsys):
    target = tmp_path / "mine.dbc"
    target.write_text("mine")
    with pytest.raises(SystemExit) as ended:
        run_protocol("--emit", "dbc", "--out", str(target))
    assert ended.value.code == 2 and target.read_text() == "mine"
