from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_imaging",
            "gpr20_imaging.high",
            "gpr20_imaging.low",
            "gpr20_imaging.mid",
        ],
        package_dir={"": "src"},
    )
)
