from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_doctor",
            "gpr20_doctor.high",
            "gpr20_doctor.low",
            "gpr20_doctor.mid",
        ],
        package_dir={"": "src"},
    )
)
