"""Folders of configurations for the tests of the check of the whole robot."""

from pathlib import Path

from gpr20_launch.mid.robot_check import check_robot
from gpr20_launch.mid.robot_files import Reading, Use


def message_field(datatype, field):
    """Find a field; only with sensors is ROS needed."""
    from gpr20_main_control.high.sensor_topics import MessageField

    return MessageField(datatype, field)


PACKAGES = Path(__file__).resolve().parents[3]
AXES = PACKAGES / "gpr20_launch/config/axes.yaml"
PROFILES = PACKAGES / "gpr20_launch/config/profiles"
VNA = "address: 192.168.1.10\n"


def write(folder, files):
    """Write files, by name; one without an ending is a YAML file."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in {"analyzer": VNA, **files}.items():
        path = folder / (name if "." in name or "~" in name else f"{name}.yaml")
        path.write_bytes(text if isinstance(text, bytes) else text.encode())


def checked(folder, environment=(), **options):
    """Return what the check finds; the state of this computer does not matter."""
    own = {"GPR20_STATE": str(folder / "state"), **dict(environment)}
    return check_robot(Reading(folder, AXES), Use(own, **options), message_field)
