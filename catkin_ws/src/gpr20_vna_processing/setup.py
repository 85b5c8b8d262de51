from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_vna_processing",
            "gpr20_vna_processing.high",
            "gpr20_vna_processing.low",
            "gpr20_vna_processing.mid",
        ],
        package_dir={"": "src"},
    )
)
