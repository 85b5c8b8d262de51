from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_common",
            "gpr20_common.high",
            "gpr20_common.low",
            "gpr20_common.mid",
        ],
        package_dir={"": "src"},
        package_data={"gpr20_common": ["translations/*.po"]},
    )
)
