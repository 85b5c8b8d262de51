"""gpr20 finds what this package adds, and names the package where it is not installed."""

import ast

import pytest
from foreign_formats_kit import PACKAGE, added

from gpr20_analysis.entry_points import additions
from gpr20_analysis.formats.conversion import EXPORTS
from gpr20_analysis.formats.format import IMAGE_FORMATS, IMPORTS
from gpr20_analysis.imaging.methods import METHODS

POINTS = {one.group: one for one in (EXPORTS, IMPORTS, IMAGE_FORMATS, METHODS)}


def test_pip_and_catkin_install_the_same_entry_points():
    (call,) = (
        node
        for node in ast.walk(ast.parse((PACKAGE / "setup.py").read_text()))
        if isinstance(node, ast.keyword) and node.arg == "entry_points"
    )
    of_catkin = {
        group: dict(line.split(" = ") for line in lines)
        for group, lines in ast.literal_eval(call.value).items()
    }
    assert of_catkin == added()


def test_gpr20_knows_what_the_package_adds_where_it_is_not_installed():
    for group, names in added().items():
        assert dict(POINTS[group].wings) == dict.fromkeys(names, PACKAGE.name)


@pytest.mark.parametrize(
    ("group", "name"), [(one, name) for one in added() for name in added()[one]]
)
def test_each_addition_can_be_loaded(group, name):
    assert name in POINTS[group].names()
    found = [one for one in additions(group) if one.name == name]
    assert len(found) == 1
    assert POINTS[group].find(name) is found[0].load()
