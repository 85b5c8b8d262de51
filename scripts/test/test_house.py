"""No part of the project grows beyond its limit."""

import pytest
from house import ROOT, complaints, limits, lines_by_part, part_of


def test_no_part_is_larger_than_its_limit_in_pyproject():
    assert complaints(lines_by_part(ROOT), limits(ROOT)) == []


@pytest.mark.parametrize(
    "name, part",
    [
        ("catkin_ws/src/gpr20_web/src/gpr20_web/static/top.js", "gpr20_web"),
        ("catkin_ws/src/gpr20_web/nodes/web", "gpr20_web"),
        ("catkin_ws/src/gpr20_web/test/unit/test_fuzz.py", "gpr20_web tests"),
        ("catkin_ws/src/gpr20/test/ros/faults.test", "gpr20 tests"),
        ("scripts/test/test_house.py", "scripts tests"),
        ("scripts/test.sh", "scripts"),
        ("conftest.py", "conftest.py"),
        ("docs/operate.md", ""),
        ("catkin_ws/src/gpr20_common/src/gpr20_common/translations/es.po", ""),
    ],
)
def test_a_file_counts_for_its_part(name, part):
    assert part_of(name) == part


def test_what_is_too_large_unknown_or_gone_is_named():
    found = complaints({"axis": 101, "web": 5}, {"axis": 100, "height": 200})
    assert [one.split()[0] for one in found] == ["axis", "web", "height"]
    assert "101" in found[0] and "100" in found[0]
