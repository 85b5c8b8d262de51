from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_vna_acquisition",
            "gpr20_vna_acquisition.high",
            "gpr20_vna_acquisition.low",
            "gpr20_vna_acquisition.mid",
        ],
        package_dir={"": "src"},
    )
)
