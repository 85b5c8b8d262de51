from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_axis_driver",
            "gpr20_axis_driver.high",
            "gpr20_axis_driver.low",
            "gpr20_axis_driver.mid",
        ],
        package_dir={"": "src"},
    )
)
