from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_height_sensor",
            "gpr20_height_sensor.high",
            "gpr20_height_sensor.low",
            "gpr20_height_sensor.mid",
        ],
        package_dir={"": "src"},
    )
)
