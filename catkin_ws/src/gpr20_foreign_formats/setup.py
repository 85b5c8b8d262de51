from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import find_packages, setup

setup(
    **generate_distutils_setup(
        packages=find_packages("src"),
        package_dir={"": "src"},
        # As in pyproject.toml, which the setuptools of ROS Noetic does not read.
        entry_points={
            "gpr20_analysis.imports": [
                "dt1 = gpr20_foreign_formats.dt1_rd3:DT1",
                "dzt = gpr20_foreign_formats.dzt:IMPORT",
                "rd3 = gpr20_foreign_formats.dt1_rd3:RD3",
                "segy = gpr20_foreign_formats.segy:IMPORT",
                "touchstone = gpr20_foreign_formats.touchstone:IMPORT",
                "group-csv = gpr20_foreign_formats.group_files:IMPORT",
                "merged-hdf5 = gpr20_foreign_formats.merged_hdf5:IMPORT",
                "gprmax = gpr20_foreign_formats.gprmax:IMPORT",
                "arrays = gpr20_foreign_formats.arrays:IMPORT",
                "original-json = gpr20_foreign_formats.original_json:IMPORT",
            ],
        },
    )
)
