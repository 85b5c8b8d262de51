from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_simulator",
            "gpr20_simulator.high",
            "gpr20_simulator.low",
            "gpr20_simulator.mid",
        ],
        package_dir={"": "src"},
    )
)
