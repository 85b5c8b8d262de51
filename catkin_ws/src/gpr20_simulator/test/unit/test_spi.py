"""The simulated bus answers as an MCP3008 does, bit by bit."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpr20_height_sensor.low.adc_interface import AdcInterface
from gpr20_simulator.low.spi import SimulatedSpi


@given(st.integers(0, 1023), st.integers(0, 7))
def test_the_driver_reads_the_code_of_the_channel_it_asks_for(code, channel):
    spi = SimulatedSpi(lambda asked: code if asked == channel else 1023 - code)
    assert AdcInterface(spi, channel).read_code() == code


def test_the_exchange_is_that_of_the_data_sheet():
    # Start bit, single-ended, channel 5; then five floating ones, the null bit, ten bits.
    spi = SimulatedSpi(lambda channel: 0b1010101011 if channel == 5 else 0)
    assert spi.xfer2([0x01, 0xD0, 0x00]) == [0xFF, 0b11111010, 0b10101011]


def test_the_answer_follows_the_start_bit_wherever_it_stands():
    # The start bit one place earlier shifts everything by one place.
    spi = SimulatedSpi(lambda channel: 0b1111111111)
    assert spi.xfer2([0x03, 0x00, 0x00]) == [0xFF, 0b11110111, 0b11111110]


def test_without_a_start_bit_nothing_drives_the_bus():
    assert SimulatedSpi(lambda channel: 5).xfer2([0, 0, 0]) == [255, 255, 255]


def test_an_exchange_that_ends_early_does_not_convert():
    def refuse(channel):
        raise AssertionError("the channel was not sent completely")

    assert SimulatedSpi(refuse).xfer2([0x01]) == [255]


def test_a_closed_bus_fails_as_the_real_one_does():
    spi = SimulatedSpi(lambda channel: 5)
    spi.close()
    with pytest.raises(OSError):
        spi.xfer2([1, 0x80, 0])
