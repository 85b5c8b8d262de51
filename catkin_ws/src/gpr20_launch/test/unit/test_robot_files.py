"""The files of the robot's configuration: every wrong key and value is named with its file."""

import dataclasses
from pathlib import Path

import yaml
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.mid.records import record_from
from gpr20_doctor.mid.bundle import CONFIGURATION
from gpr20_launch import faults
from gpr20_launch.errors import ConfigurationError
from gpr20_launch.mid.place_checks import Use
from gpr20_launch.mid.robot_check import BuiltRobot, check_robot
from gpr20_launch.mid.robot_files import AXES_FILE, FILES, read_configuration
from gpr20_launch.mid.templates import templates
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

AXES = Path(__file__).resolve().parents[2] / "config" / "axes.yaml"

# Another analyzer than the usual one.
OTHER_VNA = """\
analyzer: other_package:Vna
analyzer_options: {port: 1}
address: GPIB0::16::INSTR
maker: Agilent
model: N5222A
accepted_calibrations: [5]
"""


def read(folder, **texts):
    for name, text in texts.items():
        (folder / f"{name}.yaml").write_text(text)
    return read_configuration(folder, AXES)


def test_without_files_everything_has_its_default(tmp_path):
    sections = read(tmp_path)
    assert sections["x_axis"]["max_coord"] == 650.0
    for file in FILES.values():
        for section, kind in file.sections:
            assert record_from(kind, sections[section], section) == kind()


def test_the_bundle_for_help_has_every_file():
    assert sorted(CONFIGURATION) == sorted({*FILES, AXES_FILE})


@each_case("name", sorted(FILES))
def test_a_template_shows_every_key_with_its_default(name):
    text = templates(AXES)[name]
    shown = {}
    for line in text.splitlines():
        if line.startswith("#") and not line.startswith("# "):
            shown.update(yaml.safe_load(line[1:]))
    for _section, kind in FILES[name].sections:
        own = {field.name: shown[field.name] for field in dataclasses.fields(kind)}
        assert record_from(kind, own, name) == kind()


def test_the_template_of_the_axes_shows_the_robot_as_it_is_built(tmp_path):
    text = templates(AXES)[AXES_FILE]
    used = [line.replace("  #", "  ", 1) for line in text.splitlines()]
    sections = read(tmp_path, axes="\n".join(used))
    built = yaml.safe_load(AXES.read_text())
    for axis, values in built.items():
        assert {key: sections[f"{axis}_axis"][key] for key in values} == values


def test_templates_are_a_correct_configuration(tmp_path):
    for name, text in templates(AXES).items():
        (tmp_path / name).write_text(text)
    assert read_configuration(tmp_path, AXES) == read_configuration(tmp_path / "none", AXES)


@each_case(
    "file, text, shown",
    [
        ("height", "reference_voltage_v: '3.3'", ("reference_voltage_v", "'3.3'", "float")),
        ("analyzer", "accepted_calibrations: [1, 9]", ("accepted_calibrations[1]", "9")),
        ("analyzer", "analyzer: hp8753", ("analyzer", "'hp8753'", "ms2026c, ")),
        ("analyzer", "analyzer: scikit_rf", ("gpr20_scikit_rf:ScikitRfAnalyzer",)),
        ("analyzer", "scikit_rf_class: keysight.PNA", ("scikit_rf_class", "in analyzer_options")),
        ("analyzer", OTHER_VNA.replace("::16::", "::1 6::"), ("'GPIB0::1 6::INSTR'",)),
        ("analyzer", OTHER_VNA + "analyzer_option: {}", ("'analyzer_option'",)),
        ("analyzer", "antenna_delay_ns: 200", ("antenna_delay_ns", "200", "-100")),
        ("survey", "settle_s: -1", ("settle_s", "-1 s", "0", "60 s")),
        ("survey", "on_height_failure: guess", ("on_height_failure", "pause, store_without")),
        ("survey", "- a list", ("key: value",)),
        ("storage", "disk_reserve_mb: -5", ("disk_reserve_mb", "-5 MB")),
        ("storage", "store_queue: 0", ("store_queue", "0", "1")),
        ("storage", "message_queue: -5", ("message_queue", "-5", "1")),
        ("storage", "extra_recorded_topics: [a b]", ("'a b'",)),
        ("storage", "extra_recorded_topics: ['']", ("''",)),
        ("storage", "recorded_topics: [5/x]", ("'5/x'",)),
        ("sensors", "sensors: [5]", ("sensors[0]", "5")),
        ("axes", "q: {}", ("'q'", "x, y, z")),
        ("axes", "x: 5", ("x", "5")),
        ("axes", "x: {endstop_active: 0}", ("x/endstop_active",)),
        ("axes", "x: {enable_pin: none}", ("x/enable_pin",)),
    ],
)
def test_what_is_wrong_is_named_with_its_file(tmp_path, file, text, shown):
    path = tmp_path / f"{file}.yaml"
    with raises_fault(faults.WRONG_VALUE, path, *shown, error=ConfigurationError):
        read(tmp_path, **{file: text})
    path.unlink()


def test_keys_of_one_file_override_only_themselves(tmp_path):
    sections = read(tmp_path, axes="x: {max_coord: 600}\ny:\n", survey="settle_s: 1\n")
    assert sections["x_axis"]["max_coord"] == 600
    assert sections["x_axis"]["step_pin"] == 15
    assert sections["survey"] == {"settle_s": 1}
    assert sections["time_limits"] == {}


@each_case("name", ["Axes.yaml", "axes.YAML", "axes.yml", "hight.yaml"])
def test_a_file_of_another_name_is_refused_because_it_would_not_be_read(tmp_path, name):
    (tmp_path / name).write_text("")
    with raises_fault(faults.UNKNOWN_FILE, tmp_path / name, error=ConfigurationError):
        read(tmp_path)
    (tmp_path / name).unlink()


def test_what_editors_leave_beside_a_file_is_not_read(tmp_path):
    (tmp_path / ".#axes.yaml").symlink_to("somebody@somewhere.1234")
    (tmp_path / "._site.yaml").write_bytes(b"\0\1")
    (tmp_path / "axes.yaml~").write_text("x: 5")
    assert read(tmp_path) == read(tmp_path / "none")


@each_case("linked", ["file", "folder"])
def test_a_link_that_leads_nowhere_does_not_mean_the_defaults(tmp_path, linked):
    folder = tmp_path / linked
    if linked == "file":
        folder.mkdir()
        (folder / "axes.yaml").symlink_to("/nowhere/axes.yaml")
    else:
        folder.symlink_to("/nowhere")
    with raises_fault(faults.UNREADABLE, folder, error=ConfigurationError):
        read_configuration(folder, AXES)


@given(
    st.sampled_from([*FILES, AXES_FILE]),
    st.dictionaries(
        st.text(max_size=8),
        st.recursive(
            st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
            lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner),
            max_leaves=5,
        ),
        max_size=4,
    ),
)
def test_any_content_is_read_or_refused_with_its_file(tmp_path_factory, name, values):
    folder = tmp_path_factory.mktemp("robot")
    (folder / name).write_text(yaml.safe_dump(values))
    found = check_robot(Use(folder, {}, part="robot"), BuiltRobot(AXES))
    assert all(one.message.remedy is not None for one in found)
    try:
        read_configuration(folder, AXES)
    except ConfigurationError as error:
        assert name in str(error)
        assert any(one.refuses and name in one.file for one in found)


def test_another_analyzer_can_be_configured(tmp_path):
    sections = read(tmp_path, analyzer=OTHER_VNA)
    parameters = record_from(VnaParameters, sections["vna_acquisition"], "vna_acquisition")
    assert parameters.analyzer == "other_package:Vna"
    assert parameters.analyzer_options == {"port": 1}
    assert parameters.accepted_calibrations == (CalibrationStatus.NOT_REPORTED,)
