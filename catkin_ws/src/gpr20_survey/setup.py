from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=[
            "gpr20_survey",
            "gpr20_survey.axes",
            "gpr20_survey.files",
            "gpr20_survey.folder",
            "gpr20_survey.high",
            "gpr20_survey.plan",
            "gpr20_survey.radar",
            "gpr20_survey.recording",
            "gpr20_survey.results",
            "gpr20_survey.trace",
        ],
        package_dir={"": "src"},
    )
)
