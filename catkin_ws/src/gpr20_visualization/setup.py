from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_visualization",
            "gpr20_visualization.high",
            "gpr20_visualization.mid",
        ],
        package_dir={"": "src"},
    )
)
