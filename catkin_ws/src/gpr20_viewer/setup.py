from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=["gpr20_viewer", "gpr20_viewer.views"],
        package_dir={"": "src"},
        # As in pyproject.toml, which the setuptools of ROS Noetic does not read.
        entry_points={"gpr20.commands": ["view = gpr20_viewer.view_command:COMMAND"]},
    )
)
