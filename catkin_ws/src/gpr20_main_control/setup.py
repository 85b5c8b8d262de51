from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_main_control",
            "gpr20_main_control.high",
            "gpr20_main_control.mid",
        ],
        package_dir={"": "src"},
    )
)
