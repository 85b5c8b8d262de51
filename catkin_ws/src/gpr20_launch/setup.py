from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_launch",
            "gpr20_launch.high",
            "gpr20_launch.low",
            "gpr20_launch.mid",
        ],
        package_dir={"": "src"},
    )
)
