"""Who may include whom (doc/architecture.md): reads the #include lines, and fails on a breach."""
from __future__ import annotations

import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]

COMPONENTS = {"rotor", "magnetic_bearing", "auxiliary_bearing", "excitation", "sensing"}
_MACHINE_SEES = {"common", "model", "effects"} | COMPONENTS
_CORE = _MACHINE_SEES | {"machine", "integration", "analysis", "identification", "validation"}

# Layer -> the layers whose headers it may include, besides its own.
ALLOWED = {
    "common": set(),
    "model": {"common"},
    **{component: {"common", "model"} for component in COMPONENTS},
    "effects": {"common", "model"} | COMPONENTS,
    # The machine joins itself to an integrator; the integrator knows only an abstract system.
    "machine": _MACHINE_SEES | {"integration"},
    "integration": {"common"},
    "analysis": {"common"},
    "identification": {"common"},
    "validation": _CORE,
    "python": _CORE,
    "ros": _CORE,
    "nodes": _CORE | {"ros"},
}
ROS_LAYERS = {"ros", "nodes"}

# First folders of headers that belong to ROS, and its headers without a folder.
ROS_HEADERS = re.compile(
    r"^(ros|roscpp|roslib|rosbag|rosgraph_msgs|rosconsole|std_msgs|std_srvs|geometry_msgs|sensor_msgs|"
    r"visualization_msgs|diagnostic_msgs|diagnostic_updater|dynamic_reconfigure|nodelet|pluginlib|"
    r"class_loader|message_filters|topic_tools|tf|tf2|tf2_ros|tf2_msgs|rviz|xmlrpcpp)/")
# Instantiated once, in src/common: each file that does it too pays five to twenty seconds of compile time.
DECOMPOSITIONS = re.compile(r"^(Eigen/(Dense|Eigen|Eigenvalues|SVD|QR)|unsupported/Eigen/MatrixFunctions)$")
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)


def layer_of(path: pathlib.PurePath) -> str | None:
    """The layer of a file given relative to the root: include/amb_rotor/LAYER/..., src/LAYER/..."""
    parts = path.parts
    if parts[:2] == ("include", "amb_rotor") and len(parts) > 3:
        return parts[2]
    if parts[0] == "src" and len(parts) > 2:
        return parts[1]
    return None


def breaches(path: pathlib.PurePath, text: str) -> list[str]:
    """What is wrong with the includes of one file."""
    layer = layer_of(path)
    if layer is None:
        return [f"{path}: is in no layer's folder"]
    if layer not in ALLOWED:
        return [f"{path}: {layer} is no known layer"]
    found = []
    for header in INCLUDE.findall(text):
        if layer not in ROS_LAYERS and ROS_HEADERS.match(header):
            found.append(f"{path}: {layer} includes ROS ({header})")
        if layer != "common" and DECOMPOSITIONS.match(header):
            found.append(f"{path}: {header} is for common/linear_algebra.hpp alone")
        own = re.match(r"^amb_rotor/(?:([a-z0-9_]+)/)?([^/]+)$", header)
        if not own:
            if header.startswith((".", "amb_rotor/")):
                found.append(f"{path}: write the include from the root, amb_rotor/LAYER/FILE.hpp: {header}")
            continue
        other, name = own.groups()
        if re.match(r"^[A-Z]\w*\.h$", name):
            if layer not in ROS_LAYERS:
                found.append(f"{path}: {layer} includes a generated message ({header})")
        elif other is None:
            found.append(f"{path}: {header} is in no layer's folder")
        elif other != layer and other not in ALLOWED[layer]:
            found.append(f"{path}: {layer} may not include {other} ({header})")
    return found


def sources() -> list[pathlib.Path]:
    return [path for folder in ("include", "src") for path in sorted((ROOT / folder).rglob("*"))
            if path.suffix in (".hpp", ".cpp", ".h")]


def test_no_file_includes_against_the_layers():
    found = [line for path in sources()
             for line in breaches(path.relative_to(ROOT), path.read_text())]
    assert not found, "\n".join(found)


@pytest.mark.parametrize("path, include, complaint", [
    ("src/common/a.cpp", "amb_rotor/model/model.hpp", "common may not include model"),
    ("src/rotor/a.cpp", "amb_rotor/sensing/sensor.hpp", "rotor may not include sensing"),
    ("include/amb_rotor/rotor/a.hpp", "amb_rotor/effects/runout.hpp", "rotor may not include effects"),
    ("src/effects/a.cpp", "amb_rotor/machine/machine.hpp", "effects may not include machine"),
    ("src/integration/a.cpp", "amb_rotor/machine/machine.hpp", "integration may not include machine"),
    ("src/integration/a.cpp", "amb_rotor/model/model.hpp", "integration may not include model"),
    ("src/analysis/a.cpp", "amb_rotor/integration/run.hpp", "analysis may not include integration"),
    ("src/validation/a.cpp", "amb_rotor/ros/plant.hpp", "validation may not include ros"),
    ("src/machine/a.cpp", "amb_rotor/Fault.h", "machine includes a generated message"),
    ("src/machine/a.cpp", "ros/ros.h", "machine includes ROS"),
    ("src/python/a.cpp", "std_msgs/Header.h", "python includes ROS"),
    ("src/ros/a.cpp", "amb_rotor/nodes/main.hpp", "ros may not include nodes"),
    ("src/rotor/a.cpp", "Eigen/Eigenvalues", "is for common/linear_algebra.hpp alone"),
    ("src/rotor/a.cpp", "../sensing/sensor.hpp", "write the include from the root"),
    ("src/oddments/a.cpp", "vector", "no known layer"),
    ("include/amb_rotor/stray.hpp", "vector", "in no layer's folder"),
])
def test_a_breach_is_found(path, include, complaint):
    for text in (f'#include "{include}"\n', f"  #  include <{include}>\n"):
        assert complaint in "\n".join(breaches(pathlib.PurePath(path), text))


@pytest.mark.parametrize("path, include", [
    ("src/model/a.cpp", "amb_rotor/common/units.hpp"),
    ("src/rotor/a.cpp", "amb_rotor/rotor/shaft_element.hpp"),
    ("src/effects/a.cpp", "amb_rotor/sensing/sensor.hpp"),
    ("src/machine/a.cpp", "amb_rotor/effects/runout.hpp"),
    ("src/machine/a.cpp", "amb_rotor/integration/integrator.hpp"),
    ("src/integration/a.cpp", "Eigen/Cholesky"),
    ("src/common/a.cpp", "Eigen/Eigenvalues"),
    ("src/ros/a.cpp", "amb_rotor/Fault.h"),
    ("src/ros/a.cpp", "ros/ros.h"),
    ("src/nodes/rotor_plant_node.cpp", "amb_rotor/ros/rotor_plant.hpp"),
])
def test_what_is_allowed_is_no_breach(path, include):
    assert not breaches(pathlib.PurePath(path), f'#include "{include}"\n')


def test_a_comment_is_no_include():
    assert not breaches(pathlib.PurePath("src/common/a.cpp"), '// #include "amb_rotor/model/model.hpp"\n')
