"""The rules of the sources: the lint, the size of each part, imports, sentences."""

from __future__ import annotations

import re
import shutil

import pytest
from house import complaints, limits, lines_by_part
from sentence_comparisons import complaints as comparisons
from translations import module_files, shown_files, templates
from user_shell import ROOT, printed_by
from wings_kit import NEEDS_ALL

SOURCES = sorted(
    [*ROOT.glob("catkin_ws/src/*/src/*/__init__.py"), *ROOT.glob("deploy/*/*/__init__.py")],
    key=lambda one: one.parent.name,
)


@NEEDS_ALL
@pytest.mark.timeout(450)
def test_the_lint_finds_nothing():
    printed_by(ROOT / "scripts/lint.sh")


def test_no_part_is_larger_than_its_limit_in_pyproject():
    assert complaints(lines_by_part(ROOT), limits(ROOT)) == []


def test_what_is_too_large_unknown_or_gone_is_named():
    found = complaints({"axis": 101, "web": 5}, {"axis": 100, "height": 200})
    assert [one.split()[0] for one in found] == ["axis", "web", "height"]
    assert "101" in found[0] and "100" in found[0]


@NEEDS_ALL
def test_every_package_is_covered_by_the_contracts_on_imports():
    contracts = (ROOT / "pyproject.toml").read_text()
    roots = contracts.split("root_packages = [")[1].split("]")[0]
    assert re.findall(r'"(\w+)"', roots) == [one.parent.name for one in SOURCES]


# The lint says that the packages keep the contracts; this, that each kind of them is one.
@NEEDS_ALL
def test_imports_that_are_not_allowed_are_refused_with_what_to_do(tmp_path):
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    skipped = shutil.ignore_patterns("__pycache__")
    for source in SOURCES:
        shutil.copytree(source.parent, tmp_path / source.parent.name, ignore=skipped)
    wrong = {
        "gpr20_common/mid/checks.py": ("import gpr20_common.high.node", "from the higher level in"),
        "gpr20_survey/errors.py": ("import rospy", "pass plain values or a function to the lower"),
        "gpr20_simulator/high/__init__.py": (
            "import gpr20_main_control.errors",
            "use the topics and services of the other nodes",
        ),
        "gpr20_main_control/high/__init__.py": (
            "import gpr20_axis_driver.errors",
            "move what both need to gpr20_survey or gpr20_common",
        ),
        "gpr20_simulator/mid/world/ground.py": (
            "import gpr20_survey.radar.refraction",
            "solve it in gpr20_simulator, by another method",
        ),
        "gpr20_viewer/session.py": (
            "import gpr20_imaging.errors",
            "let gpr20_analysis offer what it needs",
        ),
        "gpr20_web/mid/web_page.py": ("import tornado.web", "let these offer what is needed"),
    }
    for file, (line, _remedy) in wrong.items():
        with (tmp_path / file).open("a") as source:
            source.write(f"{line}\n")
    own = {"PYTHONPATH": str(tmp_path), "COLUMNS": "1000"}
    said = printed_by("lint-imports", "--no-cache", "--no-logo", status=1, folder=tmp_path, **own)
    _kept, broken = said.split("Broken contracts")
    assert [remedy for _line, remedy in wrong.values() if remedy not in broken] == []


@pytest.mark.parametrize(
    "wrong",
    ["Message(text, height_m=1.0)", "Message(TEXTS[0])", "tr('it fails' if bad else 'it works')"],
)
def test_a_template_that_nobody_could_translate_is_refused(wrong):
    with pytest.raises(ValueError, match="as one literal string"):
        list(templates(wrong))


def test_templates_are_found_wherever_they_stand():
    source = "a = Message('the height ' '{m:g} m', m=1)\nb = f'{self.tr(\"it fails\")}: {name}'"
    assert set(templates(source)) == {"the height {m:g} m", "it fails"}


@NEEDS_ALL
def test_what_reaches_operators_is_translated_and_what_only_commands_say_is_not():
    files, shown = module_files(), shown_files()
    is_shown = {name: path in shown for name, path in files.items()}
    # Programs, what they import, a child process, what that takes of the public interface, what
    # is imported by its name, a driver that a file names, and who answers the window.
    for name in (
        *("gpr20_user_interface.window.rail", "gpr20_main_control.faults"),
        *("gpr20_common.errors", "gpr20_doctor.high.doctor"),
        *("gpr20_imaging.low.analysis_worker", "gpr20_analysis.read.load"),
        "gpr20_scikit_rf.low.visa_link",
        "gpr20_analysis.high.replay_node",
        # The doctor runs robot_config.
        "gpr20_launch.mid.pin_checks",
    ):
        assert is_shown[name], name
    for name in (
        *("gpr20_analysis.commands.file_commands", "gpr20_viewer.views.main_window"),
        *("gpr20_foreign_formats.segy", "gpr20_vna_acquisition.mid.conformance"),
    ):
        assert not is_shown[name], name


@pytest.mark.parametrize(
    "decision",
    [
        "message == CONTROL_SILENT",
        "state.message.sentence().startswith('Warning: ')",
        "'disk is full' in str(error)",
        "re.search('calibrat', message.sentence())",
        "reason == Message('the disk is full')",
        "error.strerror == 'No space left on device'",
        "answer.message.lower()[:4] == 'stop'",
        "f'{error}' == 'busy'",
    ],
)
def test_a_comparison_of_a_sentence_is_found(decision):
    assert list(comparisons(f"pass\nx = {decision}")) == [2]


@pytest.mark.parametrize(
    "expression",
    [
        "message.fault_code == faults.DISK_FULL.code",
        "message.cause is None",
        "message != ''",
        "problem != self.problem",
        "name.startswith('traces/')",
        "message.values.get('stored')",
    ],
)
def test_codes_types_and_whole_messages_may_be_compared(expression):
    assert list(comparisons(expression)) == []
