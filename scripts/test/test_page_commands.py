"""Every command of the pages is run as written here, or stands below with what runs it instead.

The survey of the commands is that of README's first command, in a home of its own.
"""

from __future__ import annotations

import re
import shutil

import pytest
from user_shell import ROOT, printed_by, user_environment

pytestmark = [pytest.mark.release, pytest.mark.timeout(1800)]
FILES_OF_OTHERS = ROOT / "catkin_ws/src/gpr20_foreign_formats/test/unit/data"
# What a reader fills in, and what the survey is called there.
PLACEHOLDER = r"(~/gpr20_data/|/var/lib/gpr20/surveys/|\bgpr20_data/)<survey>|\bSURVEY\b|\bFOLDER\b"
# Commands that are not run here: a pattern, and what runs them or why nothing here can.
ELSEWHERE = {
    r"^scripts/(survey|test|setup|fault_suite|install_space|packages|bundle|release|bench)\.sh": (
        "tests of their own in scripts/test, scripts/bare_debian.sh"
    ),
    r"^(sudo|gpr20-run|nft|rosdep|catkin|apt|GPR20_(ROBOT|SERVER|ADMIN)=)": (
        "a robot's own computer: test_packages.py, test_two_machines.py, scripts/package_trial.sh"
    ),
    r"^(roslaunch|rosrun|rosbag|rosservice|rosparam|rostopic|roscore|rosclean|python3 soil)": (
        "a running robot: test_launches.py, test_readme_commands.py, second_launch.test"
    ),
    r"robot_config|run_survey|user_interface|translations\.sh|LANGUAGE=": (
        "tests of their packages"
    ),
    r"^(source|export|cd|git|ros2|rsync|mv|rm|echo|ssh-keygen|compliance|~/other_ws)": (
        "the shell, another computer, or a program of others"
    ),
    r"^(\.venv/bin/)?(pip|pytest|python) |^python3? -[cm] |^pip ": "test_wheel.py, the tutorials",
    r"gpr20 (corners|import line\.scan|info line\.nc)|notch|--method columns|cleaned\.nc": (
        "the code of the tutorial: test_own_commands.py"
    ),
    r"^(kill|mount) -": "a robot that is broken on purpose: test_broken_states.py",
    r"gpr20 view": "a window: the tests of gpr20_viewer",
    r"PLATE|--plate": "a metal plate: test_antenna_model.py, test_antenna_delay.py",
    r"--signers": "a robot with a key: test_signature.py",
    r"--language pt": "the catalogue of the tutorial: test_window_settings.py",
    r"--antenna antenna\.nc": "its model: test_antenna_model.py",
    r"gpr20 import (scans|merged|~/gpr20_data)": "files of the group: test_group_files.py",
    r"--found C03": "a buried lane: test_annotations.py",
    r"^[^a-z~./]|^\w+ {2,}|^gpr20_\w+ ": "no command",
    r"^(plastic|metallic|buried|target)": "what is printed or read",
    r"^(for one in|from mcap|print\()|[^-]\bprint\(": "Python: test_public_interface.py",
}


def commands(page):
    """Yield the commands of a page, one line each."""
    text = page.read_text(encoding="utf-8")
    fences = r"(<!-- file: \S+ -->\n)?^( *)```(\w*)\n(.*?)^ *```"
    for shown, _indent, language, block in re.findall(fences, text, re.M | re.S):
        if not shown and not language:
            for line in block.replace("\\\n", " ").splitlines():
                command = re.sub(r" +# .*", "", line.strip())
                if command and not command.startswith("#"):
                    yield command


def elsewhere(command):
    return any(re.search(pattern, command) for pattern in ELSEWHERE)


PAGES = [ROOT / "README.md", *sorted(ROOT.glob("docs/**/*.md"))]
RUN = {page: [one for one in commands(page) if not elsewhere(one)] for page in PAGES}


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A home with a survey of the simulated robot, and files of another radar."""
    made = tmp_path_factory.mktemp("home")
    (made / "gpr20_data").mkdir()
    environment = user_environment(made / "gpr20_data")
    printed_by(ROOT / "scripts/survey.sh", folder=ROOT, env=environment)
    for report in made.glob("gpr20_data/*.html"):
        report.unlink()
    return made


@pytest.mark.parametrize(
    "page", [page for page, run in RUN.items() if run], ids=lambda page: page.stem
)
def test_the_commands_of_a_page_work_as_written(page, home, tmp_path):
    shutil.copy(FILES_OF_OTHERS / "sir4000.DZT", tmp_path / "LINE.DZT")
    (tmp_path / ".venv").symlink_to(ROOT / ".venv")
    environment = user_environment(home / "gpr20_data", HOME=str(home))
    (survey,) = home.glob("gpr20_data/*/survey.json")
    environment["SURVEY"] = str(survey.parent)
    environment["PATH"] = f"{ROOT}/.venv/bin:{environment['PATH']}"
    failed = []
    for command in RUN[page]:
        command = re.sub(PLACEHOLDER, '"$SURVEY"', command)
        shell = ("bash", "-c", f"{command}; echo status=$?")
        printed = printed_by(*shell, folder=tmp_path, env=environment)
        if not printed.endswith("status=0\n"):
            failed.append(f"{command}\n{printed}")
    assert not failed, "\n\n".join(failed)


def test_each_entry_of_the_list_is_about_a_command_that_is_there():
    every = [one for page in PAGES for one in commands(page)]
    assert [one for one in ELSEWHERE if not any(re.search(one, each) for each in every)] == []
