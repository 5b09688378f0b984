"""A sweep's YAML file whose keys know their lines: every fault is gathered as `file:line: key = value: rule`.

The rules that the formats of doc/formats_sweep.md share are here: keys that are missing, unknown or there twice, numbers,
laws, parameters of the basic model, axes, runs. `done()` raises what was found, all at once.
"""
from __future__ import annotations

import difflib
import math
import pathlib

import numpy
import yaml

from amb_rotor import yaml_file
from amb_rotor.errors import InputError

LAWS = {"contact": ("linear", "hertz"), "friction_law": ("spin", "sliding")}
# Law -> parameters that it does not use: naming one is a fault, so that nobody believes it counts.
UNUSED = {"linear": {"hertz_stiffness", "hertz_damping"}, "hertz": {"contact_stiffness"},
          "spin": {"surface_radius", "regularisation_speed"}, "sliding": set()}
MOST_VALUES = 10_000_000


class Document:
    """The file's content in `data`, faults in `faults`. @raise InputError: no YAML, or of another format"""

    def __init__(self, path: pathlib.Path, form: str):
        self.path, self.faults, self.lines = path, [], {}
        with yaml_file.one_message(path):
            node = yaml.compose(path.read_text(), Loader=yaml.SafeLoader)
            self.data = yaml.safe_load(path.read_text())
        if not isinstance(self.data, dict) or self.data.get("format") != form:
            raise InputError(f"{path}: format: must be {form}")
        self._note(node, "")

    def _note(self, node, where: str) -> None:
        if isinstance(node, yaml.MappingNode):
            for key, value in node.value:
                name = f"{where}{key.value}"
                if name in self.lines:
                    self.fault(name, "is there twice", key.start_mark.line + 1)
                self.lines[name] = key.start_mark.line + 1
                self._note(value, name + "/")
        elif isinstance(node, yaml.SequenceNode):
            for index, value in enumerate(node.value):
                self.lines[f"{where}{index}"] = value.start_mark.line + 1
                self._note(value, f"{where}{index}/")

    def get(self, key: str):
        """The value at a key, parts joined by `/`; None where there is none."""
        value = self.data
        for part in key.split("/"):
            if isinstance(value, dict):
                value = value.get(part)
            elif isinstance(value, list) and part.isdigit() and int(part) < len(value):
                value = value[int(part)]
            else:
                return None
        return value

    def fault(self, key: str, rule: str, line: int | None = None) -> None:
        value = self.get(key)
        shown = f" = {value}" if isinstance(value, (int, float, str)) else ""
        whole = key
        while whole not in self.lines and "/" in whole:
            whole = whole.rsplit("/", 1)[0]
        self.faults.append(f"{self.path}:{line or self.lines.get(whole, 1)}: {key.replace('/', '.')}{shown}: {rule}")

    def done(self) -> None:
        if self.faults:
            raise InputError(self.faults)

    # ---- rules
    def keys(self, where: str, required, optional=()) -> bool:
        """Is the value at `where` ("": the file) a map with these keys? What is missing or unknown is a fault."""
        found = self.get(where) if where else self.data
        if not isinstance(found, dict):
            self.fault(where, f"needs {', '.join(sorted(required))}" if required else "names, each with its value")
            return False
        head, known = f"{where}/" if where else "", [*required, *optional]
        for key in sorted(set(required) - set(found)):
            self.fault(head + key, "the key is missing")
        for key in found:
            if key not in known:
                near = difflib.get_close_matches(str(key), known, 1)
                self.fault(f"{head}{key}", "the key is not known here" + (f"; nearest: {near[0]}" if near else ""))
        return set(required) <= set(found)

    def number(self, key: str, rule: str = "a finite number", holds=lambda value: True) -> float:
        """@return NaN with a fault where it is none, or the rule does not hold"""
        value = self.get(key)
        try:  # YAML reads 1e-9 without a point as text
            found = math.nan if isinstance(value, bool) else float(value)
        except (TypeError, ValueError):
            found = math.nan
        if not math.isfinite(found) or not holds(found):
            self.fault(key, f"must be {rule}")
            return math.nan
        return found

    def numbers(self, key: str, names=None) -> dict:
        """A map of names with numbers."""
        if not self.keys(key, names or (), () if names else self.get(key) or ()):
            return {}
        return {name: self.number(f"{key}/{name}") for name in self.get(key)}

    def whole(self, key: str, least: int) -> int:
        value = self.get(key)
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            self.fault(key, f"must be a whole number of at least {least}")
            return least
        return value

    def choice(self, key: str, options) -> str:
        if self.get(key) not in options:
            self.fault(key, f"is none of {', '.join(options)}")
        return self.get(key)

    def axis(self, key: str) -> numpy.ndarray:
        """A list of numbers, `values`, or from, to and step or count."""
        spec = self.get(key)
        if isinstance(spec, dict) and "values" in spec:
            key, spec = f"{key}/values", spec["values"]
        if isinstance(spec, list):
            if not spec:
                self.fault(key, "at least one value")
            return numpy.array([self.number(f"{key}/{index}") for index in range(len(spec))])
        if not isinstance(spec, dict) or not ("step" in spec) ^ ("count" in spec):
            self.fault(key, "a list of numbers, values, or from, to and one of step and count")
            return numpy.array([])
        first, last = self.number(f"{key}/from"), self.number(f"{key}/to")
        if not math.isfinite(first + last):
            return numpy.array([])
        if "count" in spec:
            return numpy.linspace(first, last, min(self.whole(f"{key}/count", 1), MOST_VALUES))
        step = self.number(f"{key}/step", "a number that leads from `from` to `to`", lambda s: s * (last - first) > 0.0)
        if not step or not math.isfinite(step) or (last - first) / step > MOST_VALUES:
            return numpy.array([])
        # A last step that ends a rounding error behind `to` counts.
        return first + step * numpy.arange(math.floor((last - first) / step * (1 + 1e-12)) + 1)

    def laws(self, friction_default: str | None = None) -> list[str]:
        """Checks contact and friction law; the parameters of the basic model that they use."""
        from amb_rotor import _core
        chosen = [self.choice("contact", LAWS["contact"])]
        chosen.append(friction_default or self.choice("friction_law", LAWS["friction_law"]))
        idle = set().union(*(UNUSED.get(law, set()) for law in chosen))
        return [name for name in _core.basic_parameter_names() if name not in idle]

    def known(self, key: str, names: list[str]) -> None:
        """Are all keys of the map at `key` among the names?"""
        self.keys(key, (), names)

    def run(self, *extra: str) -> dict:
        """turns, kept_turns and what else the format asks for, whole numbers."""
        names = ("turns", "kept_turns", *extra)
        if not self.keys("run", names):
            return {}
        found = {name: self.whole(f"run/{name}", 1) for name in names}
        if found["kept_turns"] > found["turns"]:
            self.fault("run/kept_turns", "at most `turns`")
        return found
