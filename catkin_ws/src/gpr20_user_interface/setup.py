from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_user_interface",
            "gpr20_user_interface.high",
            "gpr20_user_interface.low",
            "gpr20_user_interface.mid",
            "gpr20_user_interface.views",
        ],
        package_dir={"": "src"},
    )
)
