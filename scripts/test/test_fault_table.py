"""Every error has a fault, every fault a first step, and every code is reported somewhere."""

import pytest
from fault_table import fault_table

from gpr20_common.message import Severity


@pytest.fixture(scope="module")
def table():
    return fault_table()


def test_every_error_class_carries_a_fault_of_its_own(table):
    print()
    for error in sorted(table.errors.values(), key=lambda one: one.fault):
        fault = table.faults.get(error.fault)
        shown = "" if fault is None else f"{fault.severity.value:8} {fault.remedy.template}"
        print(f"{error.name:28} {error.fault:34} {shown}")
    assert len(table.errors) > 60
    assert [one.name for one in table.errors.values() if not one.fault] == []


def test_every_fault_says_what_to_do_first_and_how_much_it_matters(table):
    assert [code for code, fault in table.faults.items() if fault.remedy is None] == []
    assert {fault.severity for fault in table.faults.values()} == set(Severity)


def test_every_code_is_reported_somewhere(table):
    assert set(table.faults) - table.reported == set()


def test_no_code_is_written_twice(table):
    assert table.twice == []


def test_where_something_may_still_move_the_first_step_is_about_the_motors(table):
    moving = [fault for fault in table.faults.values() if fault.may_move]
    assert moving
    for fault in moving:
        words = fault.remedy.template
        assert any(one in words for one in ("motors", "hands", "STOP")), fault.code
