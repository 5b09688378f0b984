"""Where the package's own files are: in the source tree, or installed in a catkin workspace."""
from __future__ import annotations

import os
import pathlib


def share_folder() -> pathlib.Path:
    """The folder that holds config/, launch/ and rviz/."""
    set_by_entry = os.environ.get("AMB_ROTOR_ROOT")
    if set_by_entry:
        return pathlib.Path(set_by_entry)
    here = pathlib.Path(__file__).resolve()
    for candidate in (here.parents[2], *(parent / "share" / "amb_rotor" for parent in here.parents)):
        if (candidate / "package.xml").is_file() and (candidate / "config").is_dir():
            return candidate
    raise RuntimeError(f"amb_rotor's config/ was found neither beside nor above {here}")


def build_folder() -> pathlib.Path:
    """The build folder of ./amb; only there are the tests' programs."""
    return pathlib.Path(os.environ.get("AMB_ROTOR_BUILD", share_folder() / "build"))
