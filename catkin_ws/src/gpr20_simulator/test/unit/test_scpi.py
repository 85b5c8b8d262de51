from __future__ import annotations

import math

import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st

from gpr20_simulator.mid.analyzer.scpi import (
    HeaderPattern,
    ScpiError,
    chosen_keyword,
    frequency_between,
    short_form,
    split_message,
    switch,
    whole_number_between,
)


def parts(message):
    return [(one.header, one.is_query, one.argument) for one in split_message(message)]


@each_case(
    "message, commands",
    [
        (b"*IDN?", [("*IDN", True, "")]),
        (b":CALC1:DATA? SDAT\r\n", [(":CALC1:DATA", True, "SDAT")]),
        (b"CALC1:DATA?SDAT", [(":CALC1:DATA", True, "SDAT")]),
        (b"  FREQ:STAR  10E6 ", [(":FREQ:STAR", False, "10E6")]),
        (
            b":FREQ:STAR 1;:FREQ:STOP 2;*IDN?",
            [(":FREQ:STAR", False, "1"), (":FREQ:STOP", False, "2"), ("*IDN", True, "")],
        ),
        (b':INST "A;B";:INST?', [(":INST", False, '"A;B"'), (":INST", True, "")]),
        (b"", []),
        (b";;;", []),
    ],
)
def test_message_is_split_into_its_commands(message, commands):
    assert parts(message) == commands


def test_later_command_without_its_colon_is_not_understood():
    assert parts(b":FREQ:STAR 1;FREQ:STOP 2") == [(":FREQ:STAR", False, "1")]


@each_case(
    "pattern, header, numbers",
    [
        ("[:SENSe]:FREQuency:STARt", ":SENS:FREQ:STAR", ()),
        ("[:SENSe]:FREQuency:STARt", ":sense:frequency:start", ()),
        ("[:SENSe]:FREQuency:STARt", ":FREQuency:STAR", ()),
        ("[:SENSe]:TRACe#:SPARams", ":SENS:TRACE1:SPAR", (1,)),
        ("[:SENSe]:TRACe#:SPARams", ":TRAC4:SPARAMS", (4,)),
        ("[:SENSe]:TRACe#:SPARams", ":TRAC:SPAR", (1,)),
        ("[:SENSe#]:FREQuency:DATA", ":SENSE1:FREQ:DATA", (1,)),
        ("[:SENSe#]:FREQuency:DATA", ":FREQ:DATA", (1,)),
        (":INITiate[:IMMediate]", ":INIT", ()),
        (":INITiate[:IMMediate]", ":INITIATE:IMM", ()),
        ("*IDN", "*idn", ()),
    ],
)
def test_documented_spellings_match(pattern, header, numbers):
    assert HeaderPattern(pattern).match(header) == numbers


@each_case(
    "pattern, header",
    [
        ("[:SENSe]:FREQuency:STARt", ":SENS:FREQU:STAR"),
        ("[:SENSe]:FREQuency:STARt", ":FREQ:STA"),
        ("[:SENSe]:FREQuency:STARt", ":SENS1:FREQ:STAR"),
        ("[:SENSe]:FREQuency:STARt", "FREQ:STAR"),
        ("[:SENSe]:TRACe#:SPARams", ":TRAC1:SPARAMETER"),
        (":INITiate[:IMMediate]", ":INIT:IMME"),
        ("*IDN", ":*IDN"),
    ],
)
def test_spellings_between_short_and_long_do_not_match(pattern, header):
    assert HeaderPattern(pattern).match(header) is None


def test_short_form_is_the_capitals():
    assert [short_form(one) for one in ("SMITh", "LM/2", "REAL,32")] == ["SMIT", "LM/2", "REAL,32"]


@each_case(
    "text, hertz",
    [
        ("600000000", 6e8),
        ("6E8", 6e8),
        ("600MHZ", 6e8),
        ("600 mahz", 6e8),
        ("0.6GHz", 6e8),
        ("600000 KHZ", 6e8),
        ("+6.0e+8 HZ", 6e8),
    ],
)
def test_frequencies_with_units_are_understood(text, hertz):
    assert frequency_between(text, 5e3, 6e9) == pytest.approx(hertz, rel=1e-15)


@each_case(
    "text",
    ["", "nan", "inf", "1_000", "600 MS", "1e999", "-6e8", "7GHZ", "4999", "0x10", "6e8 6e8"],
)
def test_what_is_no_frequency_in_range_is_refused(text):
    with pytest.raises(ScpiError):
        frequency_between(text, 5e3, 6e9)


@each_case("text", ["1", "4002", "500.5", "NAN", "500HZ", ""])
def test_what_is_no_number_of_points_is_refused(text):
    with pytest.raises(ScpiError):
        whole_number_between(text, 2, 4001)


@each_case("text, on", [("ON", True), ("1", True), ("off", False), ("0", False)])
def test_switches_are_understood(text, on):
    assert switch(text) is on


def test_keyword_must_be_short_or_long():
    assert chosen_keyword("smith", ("SMITh", "REAL")) == "SMIT"
    with pytest.raises(ScpiError, match="SMITh"):
        chosen_keyword("SMI", ("SMITh", "REAL"))


@given(st.binary(max_size=100))
def test_no_bytes_break_the_splitting(message):
    for command in split_message(message):
        assert command.header[0] in ":*"
        assert "?" not in command.header
        assert not any(letter.isspace() for letter in command.header)


@given(st.text(max_size=30))
def test_no_text_becomes_a_frequency_out_of_range(text):
    try:
        value_hz = frequency_between(text, 5e3, 6e9)
    except ScpiError:
        return
    assert math.isfinite(value_hz)
    assert 5e3 <= value_hz <= 6e9
