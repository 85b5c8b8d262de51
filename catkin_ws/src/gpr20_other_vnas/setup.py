from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_other_vnas",
            "gpr20_other_vnas.low",
            "gpr20_other_vnas.mid",
        ],
        package_dir={"": "src"},
    )
)
