from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=["gpr20_foreign_formats"],
        package_dir={"": "src"},
        # As in pyproject.toml, which the setuptools of ROS Noetic does not read.
        entry_points={
            "gpr20_analysis.imaging_methods": [
                "kirchhoff = gpr20_foreign_formats.kirchhoff:KIRCHHOFF",
                "kirchhoff-2d = gpr20_foreign_formats.kirchhoff:KIRCHHOFF_2D",
            ],
        },
    )
)
