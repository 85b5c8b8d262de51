"""What can differ between Pythons works under the others that the code is written for.

scripts/test.sh makes a virtual environment for each of them that this machine has, for a release.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import List, Optional, Sequence

import pytest
from pytest_gpr20.processes import run_limited
from pytest_gpr20.workspace import without_ros
from user_shell import ROOT

LIMIT_S = 900.0
EVERYTHING = sorted(path.parts[-3] for path in ROOT.glob("catkin_ws/src/*/test/unit"))
# As few as the examples of hypothesis: what is random is drawn under Debian's Python.
FEW_DRAWS = {
    "GPR20_DAMAGES": "10",
    "GPR20_MARKER_DRAWS": "4",
    "GPR20_NOISE_SURVEYS": "4",
    "GPR20_REPLAY_SEQUENCES": "30",
    "GPR20_ROUND_TRIPS": "2",
    "GPR20_SCENES": "2",
    "GPR20_SEEDS": "1",
    "GPR20_TOUCHES": "3000",
}
# Of these, only what reads, writes, starts processes or loads a library differs between Pythons;
# the rest computes or draws, and Debian's Python runs it.
CHOSEN = {
    "gpr20_analysis": [
        *("test_aux_values", "test_candidate_files", "test_gpr20_command"),
        *("test_languages", "test_load_survey", "test_markers"),
        *("test_netcdf_conventions", "test_outputs", "test_own_commands", "test_own_steps"),
        *("test_processing_chain", "test_public_interface", "test_sample_survey"),
        "test_ros2_bag::test_random_messages_of_every_type_come_to_ros2_equal",
        "test_ros2_bag::test_a_recorded_survey_comes_to_ros2_equal",
        *("test_segy_files", "test_truncated_bags", "test_zarr_codecs"),
    ],
    "gpr20_foreign_formats": ["test_gprmax_import"],
    # What the worker computes and writes, the tests of the analysis choose; here it is the process.
    "gpr20_imaging": [
        "test_analysis_worker::test_a_reason_comes_with_its_fault",
        *("test_exporting", "test_usb_volumes"),
    ],
    "gpr20_main_control": ["test_survey_run", "test_survey_stop", "test_workers"],
    "gpr20_simulator": [
        *("test_rpc", "test_rpc_server", "test_scpi", "test_spi", "test_stale_states"),
        *("test_vxi11_clients", "test_vxi11_server"),
    ],
    "gpr20_vna_acquisition": [
        *("test_block_parser", "test_ms2026c_settings", "test_own_analyzer"),
        *("test_vxi11_library", "test_vxi11_packing", "test_vxi11_transport"),
    ],
    "gpr20_user_interface": [
        *("test_display_probe", "test_main_window", "test_own_language", "test_settings_file"),
        *("test_stop_signals", "test_survey_arguments", "test_translations"),
    ],
    "gpr20_vna_processing": [
        *("test_bag_file", "test_data_processing", "test_mcap_file"),
        *("test_old_surveys", "test_reopening", "test_survey_archive"),
    ],
    "gpr20_web": [
        *("test_accounts", "test_certificate", "test_event_streams", "test_http_server"),
        *("test_notifier", "test_web_downloads"),
    ],
    "gpr20": [],
    "gpr20_viewer": ["test_view_command", "test_view_picks"],
}
# Slow, and the same under each Python: motion over time, what the kernel does, random changes.
LEFT_OUT = ["test_axis_controller", "test_data_disk", "test_firewall_probe", "test_log_recovery"]
LEFT_OUT += ["test_injected_faults", "test_mutated_robot", "test_pulse_client", "test_signature"]
LEFT_OUT += ["test_tcp_keepalive"]
# What these computers have no use for: ROS, and what the robot's pins and buses need.
ABSENT = "actionlib diagnostic_msgs diagnostic_updater genpy geometry_msgs gpr20_msgs pigpio rosbag"
ABSENT += " roslaunch rosgraph rosgraph_msgs roslib rospkg rospy sensor_msgs spidev std_msgs"
ABSENT += " std_srvs tf2_msgs tf2_ros visualization_msgs RPi"
IMPORT_ALL = """
import importlib, pkgutil, sys
absent = set(sys.argv[1].split())
for package in sys.argv[2:]:
    path = importlib.import_module(package).__path__
    for module in pkgutil.walk_packages(path, package + "."):
        try:
            importlib.import_module(module.name)
        except ModuleNotFoundError as error:
            if error.name.split(".")[0] not in absent:
                raise
"""


@dataclass(frozen=True)
class OtherPython:
    """A Python without ROS.

    Attributes:
        version: Its version.
        venv: Its virtual environment, a folder of the checkout.
        packages: The packages whose code is written for it.
        left_out: Tests of these packages that need others.
    """

    version: str
    venv: str
    packages: Sequence[str]
    left_out: Sequence[str] = ()

    @property
    def program(self) -> Path:
        """The interpreter."""
        return ROOT / self.venv / "bin/python"


# That of ROS Noetic, and a new one: the analysis also runs on other computers.
PYTHONS = [
    OtherPython("3.8", ".venv38", EVERYTHING),
    OtherPython("3.13", ".venv313", ["gpr20_analysis", "gpr20_common", "gpr20_survey"]),
]
# The libraries that Ubuntu 20.04 brings, on demand: CONTRIBUTING.md. The analysis needs later ones.
if "GPR20_UBUNTU_VENV" in os.environ:
    ANALYSIS = {"gpr20_analysis", "gpr20_foreign_formats", "gpr20_imaging", "gpr20_viewer"}
    PYTHONS.append(
        OtherPython(
            "ubuntu20.04",
            os.environ["GPR20_UBUNTU_VENV"],
            sorted({*EVERYTHING} - ANALYSIS - {"gpr20_scikit_rf"}),
            ["test_old_surveys", "test_own_language"],
        )
    )


def with_code(packages: Sequence[str]) -> List[str]:
    """Return those of the packages that have Python code."""
    return [one for one in packages if (ROOT / "catkin_ws/src" / one / "src").is_dir()]


def chosen_tests(package: str) -> List[str]:
    """Return the test files of a package, or tests, that run under the other Pythons."""
    folder = ROOT / "catkin_ws/src" / package / "test/unit"
    found = {path.stem: str(path) for path in sorted(folder.rglob("test_*.py"))}
    names = CHOSEN.get(package, sorted(set(found).difference(LEFT_OUT)))
    return [name.replace(name.split("::")[0], found[name.split("::")[0]]) for name in names]


def oldest_python() -> Optional[str]:
    """Return the interpreter that the code is written for, if this machine has it."""
    versions = Path.home() / ".pyenv/versions"
    for one in ("python3.8", *map(str, sorted(versions.glob("3.8.*/bin/python")))):
        found = shutil.which(one)
        # A version manager may have a command of that name that only says which to choose.
        if found and subprocess.run([found, "--version"], capture_output=True).returncode == 0:
            return found
    return None


def test_every_source_file_is_compiled_by_the_python_of_noetic(tmp_path):
    python = oldest_python()
    if python is None:
        pytest.skip("no Python 3.8 here")
    folders = ["benchmarks", "catkin_ws/src", "deploy", "scripts", "tools"]
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(tmp_path)}
    compiled = [python, "-m", "compileall", "-q", *folders]
    ended = run_limited(compiled, environment, LIMIT_S, ROOT)
    assert ended.status == 0, ended.printed


@pytest.mark.release
@pytest.mark.parametrize("python", PYTHONS, ids=lambda python: python.version)
def test_the_unit_tests_pass_under(python, request):
    if not python.program.exists():
        pytest.skip(f"no Python {python.version} here ({python.venv})")
    environment = {name: value for name, value in os.environ.items() if "PYTEST" not in name}
    environment.update(FEW_DRAWS)
    cache = request.config.cache.mkdir(f"python{python.version}")
    options = ["-q", "-p", "no:rerunfailures", "-p", "no:xdist", "-o", f"cache_dir={cache}"]
    options.append("--hypothesis-profile=few_examples")
    if getattr(request.node, "execution_count", 1) > 1:
        options.append("--last-failed")
    tests = [test for package in python.packages for test in chosen_tests(package)]
    tests = [test for test in tests if Path(test).stem not in python.left_out]
    ended = run_limited(
        [str(python.program), "-m", "pytest", *options, *tests],
        without_ros(environment),
        LIMIT_S,
        ROOT,
    )
    assert ended.status == 0, ended.printed


@pytest.mark.release
@pytest.mark.parametrize("python", PYTHONS, ids=lambda python: python.version)
def test_every_module_is_imported_under(python):
    if not python.program.exists():
        pytest.skip(f"no Python {python.version} here ({python.venv})")
    ended = run_limited(
        [str(python.program), "-c", IMPORT_ALL, ABSENT, *with_code(python.packages)],
        without_ros(os.environ),
        LIMIT_S,
        ROOT,
    )
    assert ended.status == 0, ended.printed
