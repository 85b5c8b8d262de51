from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_analysis",
            "gpr20_analysis.candidates",
            "gpr20_analysis.commands",
            "gpr20_analysis.formats",
            "gpr20_analysis.high",
            "gpr20_analysis.imaging",
            "gpr20_analysis.plotting",
            "gpr20_analysis.processing",
            "gpr20_analysis.read",
            "gpr20_analysis.report",
            "gpr20_analysis.sample",
        ],
        package_data={"gpr20_analysis.sample": ["survey.mcap"]},
        package_dir={"": "src"},
    )
)
