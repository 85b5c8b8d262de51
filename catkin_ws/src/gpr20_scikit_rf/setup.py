from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_scikit_rf",
            "gpr20_scikit_rf.low",
            "gpr20_scikit_rf.mid",
        ],
        package_dir={"": "src"},
    )
)
