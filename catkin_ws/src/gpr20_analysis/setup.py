from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_analysis",
            "gpr20_analysis.commands",
            "gpr20_analysis.high",
            "gpr20_analysis.low",
            "gpr20_analysis.mid",
            "gpr20_analysis.mid.formats",
            "gpr20_analysis.mid.imaging",
            "gpr20_analysis.mid.plotting",
            "gpr20_analysis.mid.processing",
            "gpr20_analysis.mid.report",
        ],
        package_dir={"": "src"},
        entry_points={
            "console_scripts": [
                "gpr20 = gpr20_analysis.commands.main:main",
                "gpr20-verify = gpr20_analysis.verify:main",
            ]
        },
    )
)
