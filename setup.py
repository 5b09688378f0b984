"""Read by catkin_python_setup(); not for use by hand."""
import pathlib

from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

ROOT = pathlib.Path(__file__).resolve().parent / "python"
PACKAGES = sorted(
    ".".join(file.parent.relative_to(ROOT).parts) for file in (ROOT / "amb_rotor").rglob("__init__.py")
)

setup(**generate_distutils_setup(packages=PACKAGES, package_dir={"": "python"},
                                 package_data={"amb_rotor": ["**/*.html", "**/*.css", "**/*.js"]}))
