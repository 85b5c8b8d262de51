from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import find_packages, setup

setup(
    **generate_distutils_setup(
        packages=find_packages("src"),
        package_dir={"": "src"},
        # As in pyproject.toml, which the setuptools of ROS Noetic does not read.
        entry_points={"gpr20.commands": ["view = gpr20_viewer.view_command:COMMAND"]},
    )
)
