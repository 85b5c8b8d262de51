from __future__ import annotations

import pytest
from case_kit import each_case
from fault_kit import raises_fault

from gpr20_simulator.errors import FaultError
from gpr20_simulator.faults import UNKNOWN_FAULT
from gpr20_simulator.low.capture import CaptureFolder
from gpr20_simulator.low.shared_state import AdcFault, EndstopFault, open_shared_state
from gpr20_simulator.mid.analyzer.vna_faults import FaultBoard, VnaFault
from gpr20_simulator.mid.faults import FaultSwitch
from gpr20_survey.axes.axis_id import AxisId


@pytest.fixture
def state(tmp_path):
    return open_shared_state(tmp_path / "state", {axis: 0 for axis in AxisId})


@pytest.fixture
def board():
    return FaultBoard()


@pytest.fixture
def switch(state, board):
    return FaultSwitch(state, board)


def test_fault_of_the_analyzer_reaches_its_board(switch, board):
    assert "SIMULATED vna" in str(switch.set("vna", "truncate", 2))
    assert [board.strikes(VnaFault.TRUNCATE) for _ in range(3)] == [True, True, False]


def test_none_switches_all_faults_of_the_analyzer_off(switch, board):
    switch.set("vna", "HANG", 0)
    switch.set("vna", "NAN", 0)
    switch.set("vna", "none", 0)
    assert board.names() == ""


def test_timed_fault_lasts_as_many_seconds_as_counted(state):
    now_s = [100.0]
    board = FaultBoard(lambda: now_s[0])
    noted = []
    board.on_set(noted.append)
    message = FaultSwitch(state, board).set("vna", "link_gone", 20)
    assert str(message) == "SIMULATED vna: fault LINK_GONE for 20 s"
    assert noted == [VnaFault.LINK_GONE]
    now_s[0] += 19.9
    # However often it strikes meanwhile.
    assert all(board.is_on(VnaFault.LINK_GONE) for _ in range(100))
    now_s[0] += 0.2
    assert not board.is_on(VnaFault.LINK_GONE)
    assert board.names() == ""
    board.set("LINK_GONE", 0)
    now_s[0] += 1e6
    assert board.is_on(VnaFault.LINK_GONE)
    board.clear()
    assert not board.is_on(VnaFault.LINK_GONE)


def test_damage_lasts_longer_than_the_fault_until_it_is_cleared(board):
    board.set("LOSES_CALIBRATION", 1)
    assert not board.has_damaged(VnaFault.LOSES_CALIBRATION)
    assert board.damages(VnaFault.LOSES_CALIBRATION)
    assert not board.damages(VnaFault.LOSES_CALIBRATION)
    assert board.has_damaged(VnaFault.LOSES_CALIBRATION)
    assert board.names() == "LOSES_CALIBRATION"
    board.clear()
    assert not board.has_damaged(VnaFault.LOSES_CALIBRATION)


@each_case("device, axis", [("endstop_x", AxisId.X), ("endstop_y", AxisId.Y)])
def test_fault_of_an_endstop_reaches_the_state(switch, state, device, axis):
    switch.set(device, "stuck_closed", 0)
    assert state.endstop_fault(axis) is EndstopFault.STUCK_CLOSED
    assert switch.names() == f"{device} STUCK_CLOSED"
    switch.set(device, "none", 0)
    assert state.endstop_fault(axis) is EndstopFault.NONE
    assert switch.names() == ""


def test_fault_of_the_converter_reaches_the_state(switch, state):
    switch.set("adc", "OUT_OF_RANGE", 0)
    assert state.adc_fault is AdcFault.OUT_OF_RANGE
    assert switch.names() == "adc OUT_OF_RANGE"


@each_case(
    "device, fault, count, shown",
    [
        ("gpu", "HANG", 0, ("'gpu'", "vna, endstop_x, endstop_y, adc")),
        ("vna", "STUCK", 0, ("'STUCK'", "NONE, HANG")),
        ("vna", "HANG", -1, ("count", -1)),
        ("endstop_x", "HANG", 0, ("NONE, STUCK_OPEN, STUCK_CLOSED",)),
        ("adc", "STUCK", 3, (3,)),
        ("", "", 0, ("vna, endstop_x, endstop_y, adc",)),
    ],
)
def test_what_does_not_exist_is_refused_with_what_does(switch, device, fault, count, shown):
    with raises_fault(UNKNOWN_FAULT, *shown, error=FaultError):
        switch.set(device, fault, count)
    assert switch.names() == ""


def test_captured_replies_are_numbered_files_and_never_overwritten(tmp_path):
    folder = CaptureFolder(tmp_path / "new" / "capture")
    folder.save("sdat", b"first")
    folder.save("freq", b"second")
    CaptureFolder(tmp_path / "new" / "capture").save("sdat", b"third")
    files = sorted((tmp_path / "new" / "capture").iterdir())
    assert [(one.name, one.read_bytes()) for one in files] == [
        ("000001_sdat.bin", b"first"),
        ("000002_freq.bin", b"second"),
        ("000003_sdat.bin", b"third"),
    ]
