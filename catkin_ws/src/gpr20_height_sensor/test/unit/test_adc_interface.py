"""Three bytes to the converter, three bytes back, and nothing but a converter believed."""

from __future__ import annotations

import sys
from types import SimpleNamespace

from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.faults import NOT_SET_UP
from gpr20_height_sensor.adc_interface import CHANNELS, AdcInterface, open_spi_bus
from gpr20_height_sensor.faults import HeightError
from gpr20_survey.faults import SENSOR_FAILED


class Spi:
    """The library's class: its settings only work on an open bus, and it may change the list."""

    refused = None

    def __init__(self, reply=(0, 0, 0)):
        self.reply, self.sent = reply, []
        self.opened, self.closed = None, False
        Spi.last = self

    def open(self, *place):
        if self.refused:
            raise self.refused
        self.opened = place

    def __setattr__(self, name, value):
        assert name not in ("max_speed_hz", "mode") or self.opened, "settings before open are lost"
        super().__setattr__(name, value)

    def xfer2(self, values):
        self.sent.append(list(values))
        values[:] = [0xAA] * len(values)
        if isinstance(self.reply, Exception):
            raise self.reply
        return self.reply

    def close(self):
        self.closed = True


@given(st.integers(0, CHANNELS - 1), st.integers(0, 1023), st.integers(0, 255), st.integers(0, 31))
def test_each_reading_is_a_conversion_of_its_channel_whatever_floats_before_the_ten_bits(
    channel, code, first, floating
):
    spi = Spi([first, floating << 3 | code >> 8, code & 0xFF])
    adc = AdcInterface(spi, channel)
    assert [adc.read_code(), adc.read_code()] == [code, code]
    assert spi.sent == [[0x01, 0x80 | channel << 4, 0x00]] * 2


@each_case("reply", [[255, 255, 255], [0, 4, 0], OSError("broken")])
def test_what_no_converter_answers_and_a_failing_bus_are_our_error(reply):
    with raises_fault(SENSOR_FAILED, error=HeightError):
        AdcInterface(Spi(reply), 0).read_code()


def test_the_bus_is_opened_with_clock_and_mode_or_named_and_released(monkeypatch):
    monkeypatch.setitem(sys.modules, "spidev", SimpleNamespace(SpiDev=Spi))
    spi = open_spi_bus(1, 2, 500_000)
    assert (spi.opened, spi.max_speed_hz, spi.mode) == ((1, 2), 500_000, 0)
    monkeypatch.setattr(Spi, "refused", FileNotFoundError("no such file"))
    with raises_fault(NOT_SET_UP, "/dev/spidev0.1", error=HeightError):
        open_spi_bus(0, 1, 1_000_000)
    assert Spi.last.closed
    monkeypatch.setitem(sys.modules, "spidev", None)
    with raises_fault(NOT_SET_UP, error=HeightError):
        open_spi_bus(0, 0, 1_000_000)
