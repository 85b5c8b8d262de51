"""Three bytes to the converter, three bytes back, and nothing but a converter believed."""

from __future__ import annotations

import sys
import types

from case_kit import each_case
from fault_kit import raises_fault

from gpr20_common.faults import NOT_SET_UP
from gpr20_height_sensor.errors import HeightError
from gpr20_height_sensor.low.adc_interface import AdcInterface, open_spi_bus
from gpr20_survey.faults import SENSOR_FAILED


class FakeSpi:
    def __init__(self, reply):
        self.reply = reply
        self.sent = []
        self.closed = False

    def xfer2(self, values):
        self.sent.append(list(values))
        # As spidev may, write into the caller's list.
        values[:] = [0xAA] * len(values)
        if isinstance(self.reply, Exception):
            raise self.reply
        return self.reply

    def close(self):
        self.closed = True


@each_case("channel, second", [(0, 0x80), (1, 0x90), (7, 0xF0)])
def test_asks_for_a_single_ended_conversion_each_time(channel, second):
    spi = FakeSpi([0, 0, 0])
    adc = AdcInterface(spi, channel)
    adc.read_code()
    adc.read_code()
    assert spi.sent == [[0x01, second, 0x00]] * 2


@each_case("floating", [0x00, 0xF8])
@each_case("code", [0, 1, 255, 256, 511, 512, 1023])
def test_reads_ten_bits_whatever_floats_before_them(code, floating):
    reply = [0xFF if floating else 0, floating | code >> 8, code & 0xFF]
    assert AdcInterface(FakeSpi(reply), 0).read_code() == code


@each_case("reply", [[255, 255, 255], [0, 4, 0], [], [0, 0], [0, 0, 0, 0], [0, 0, 256], [0, 0, -1]])
def test_refuses_a_reply_that_no_converter_gives(reply):
    with raises_fault(SENSOR_FAILED, error=HeightError):
        AdcInterface(FakeSpi(reply), 0).read_code()


def test_a_failing_bus_is_our_error():
    with raises_fault(SENSOR_FAILED, "broken", error=HeightError):
        AdcInterface(FakeSpi(OSError("broken")), 0).read_code()


def test_a_missing_library_is_a_clear_error(monkeypatch):
    monkeypatch.setitem(sys.modules, "spidev", None)
    with raises_fault(NOT_SET_UP, error=HeightError):
        open_spi_bus(0, 0, 1_000_000)


class FakeSpiDev(FakeSpi):
    """The library's class; its settings only work on an open bus."""

    failure = None
    last = None

    def __init__(self):
        super().__init__([0, 0, 0])
        self.opened = None
        FakeSpiDev.last = self

    def open(self, bus, device):
        if self.failure:
            raise self.failure
        self.opened = (bus, device)

    def __setattr__(self, name, value):
        if name in ("max_speed_hz", "mode"):
            assert self.opened, "settings before open are lost"
        super().__setattr__(name, value)


def test_the_bus_is_opened_with_clock_and_mode_or_named_and_released(monkeypatch):
    monkeypatch.setitem(sys.modules, "spidev", types.SimpleNamespace(SpiDev=FakeSpiDev))
    spi = open_spi_bus(1, 2, 500_000)
    assert (spi.opened, spi.max_speed_hz, spi.mode) == ((1, 2), 500_000, 0)
    monkeypatch.setattr(FakeSpiDev, "failure", FileNotFoundError("no such file"))
    with raises_fault(NOT_SET_UP, "/dev/spidev0.1", error=HeightError):
        open_spi_bus(0, 1, 1_000_000)
    assert FakeSpiDev.last.closed
