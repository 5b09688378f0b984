"""`amb convert`: tables of numbers between csv, npz and bag. A bag is that of a table, or of a run of the node graph."""
from __future__ import annotations

import argparse
import collections
import contextlib
import gzip
import pathlib
import shutil
import sys
import tempfile

HELP = "convert between csv, npz and bag"
EXAMPLE = "amb convert overload.bag overload.csv"

TABLE_TOPIC = "/table"
KINDS = (".csv", ".csv.gz", ".npz", ".bag")
# A bag cannot hold a time of 0: stamps are t_s plus this.
_STAMP_OFFSET_S = 1.0
_RUN_TOPICS = ("/rotor/state", "/auxiliary_bearing/contact", "/injector/injection")
_AXES = ("ax", "ay", "bx", "by")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("input", metavar="IN", help="table (.csv, .csv.gz, .npz) or bag")
    parser.add_argument("output", metavar="OUT", help="file to write; its ending says as what")


def kind_of(path: pathlib.Path) -> str:
    from amb_rotor.errors import InputError

    for kind in sorted(KINDS, key=len, reverse=True):
        if path.name.endswith(kind):
            return kind
    raise InputError(f"{path}: its ending must be one of {', '.join(KINDS)}")


# A table is a dict: column (name with unit) -> numpy array of float64, all of one length.

def _checked(path, names: list[str], rows: list[list[float]]) -> dict:
    import numpy as np

    from amb_rotor.errors import InputError

    doubled = sorted({name for name in names if names.count(name) > 1})
    if doubled or not names or "" in names:
        raise InputError(f"{path}: column names must be there once each: {', '.join(doubled) or 'one is empty'}")
    values = np.asarray(rows, dtype=float).reshape(len(rows), len(names))
    return {name: values[:, i].copy() for i, name in enumerate(names)}


def read_csv(path: pathlib.Path) -> dict:
    import zlib

    from amb_rotor import _core
    from amb_rotor.errors import InputError

    try:
        data = gzip.decompress(path.read_bytes()) if path.name.endswith(".gz") else path.read_bytes()
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        raise InputError(f"{path}: the compressed file is cut off or damaged: {error}") from None
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        other = _core.other_table_format(data.decode("latin-1"))
        raise InputError(f"{path}: {other or f'is no text in UTF-8: {error}'}") from None
    if other := _core.other_table_format(text):
        raise InputError(f"{path}:1: {other}")
    if not text.strip():
        raise InputError(f"{path}: the table is empty: not even a header")
    lines = text.splitlines()
    names = [name.strip() for name in lines[0].split(",")] if lines else []
    rows, faults = [], []
    for number, line in enumerate(lines[1:], start=2):
        try:
            row = [float(cell) for cell in line.split(",")]
        except ValueError as error:
            faults.append(f"{path}:{number}: {error}")
            continue
        if len(row) != len(names):
            faults.append(f"{path}:{number}: {len(row)} cells, the header has {len(names)}")
        rows.append(row)
    if faults:
        raise InputError(faults[:20] + ([f"{path}: and {len(faults) - 20} more bad lines"] if len(faults) > 20 else []))
    return _checked(path, names, rows)


def read_npz(path: pathlib.Path) -> dict:
    import zipfile
    import zlib

    import numpy as np

    from amb_rotor.errors import InputError

    try:
        with np.load(path, allow_pickle=False) as archive:
            table = {name: archive[name] for name in archive.files}
    except (ValueError, OSError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise InputError(f"{path}: is no whole npz archive of columns: {error}") from None
    columns = {name: values for name, values in table.items() if values.ndim == 1 and values.dtype.kind == "f"}
    if not columns or len({len(values) for values in columns.values()}) != 1:
        raise InputError(f"{path}: needs columns of numbers of one length")
    return columns


@contextlib.contextmanager
def _opened(path: pathlib.Path):
    """A bag to read. Of one that was cut off (no index at its end) what is whole is read, from a copy, and said so."""
    import rosbag

    from amb_rotor.errors import InputError

    try:
        bag = rosbag.Bag(str(path))
    except rosbag.ROSBagUnindexedException:
        with tempfile.TemporaryDirectory() as folder:
            copy = pathlib.Path(folder) / "whole.bag"
            shutil.copyfile(path, copy)
            try:
                bag = rosbag.Bag(str(copy), "a", allow_unindexed=True)
                with bag:
                    collections.deque(bag.reindex(), maxlen=0)
                bag = rosbag.Bag(str(copy))
            except Exception:  # whatever rosbag meets in what is left
                raise InputError(f"{path}: the bag was cut off, and nothing in it is whole") from None
            count = bag.get_message_count()
            if not count:
                raise InputError(f"{path}: the bag was cut off, and nothing in it is whole")
            print(f"amb convert: {path}: the bag was cut off; {count} messages before the cut are read", file=sys.stderr)
            with bag:
                yield bag
        return
    except Exception as error:  # whatever rosbag meets in what is none
        raise InputError(f"{path}: is no bag that can be read: {error}") from None
    with bag:
        yield bag


def read_bag(path: pathlib.Path) -> dict:
    from amb_rotor.errors import InputError

    with _opened(path) as bag:
        topics = bag.get_type_and_topic_info().topics
        if TABLE_TOPIC in topics:
            rows = [message for _, message, _ in bag.read_messages(topics=[TABLE_TOPIC])]
            return _checked(path, list(rows[0].columns), [list(row.values) for row in rows])
        absent = [topic for topic in _RUN_TOPICS if topic not in topics]
        if absent:
            raise InputError(f"{path}: holds neither a table ({TABLE_TOPIC}) nor a run ({', '.join(absent)} is missing)")
        return run_table(bag)


def run_table(bag) -> dict:
    """The recorded instants of a run: what a data set's table holds, and what only a simulation knows."""
    import numpy as np

    by_step = {topic: {} for topic in _RUN_TOPICS}
    for topic, message, _ in bag.read_messages(topics=list(_RUN_TOPICS)):
        by_step[topic].setdefault(message.step, message)
    states, contacts, injections = (by_step[topic] for topic in _RUN_TOPICS)
    rows = []
    for step in sorted(states):
        state, contact, injection = states[step], contacts.get(step), injections.get(step)
        if state.record < 0 or contact is None or injection is None:
            continue
        row = {"t_s": state.time, "angle_rad": state.shaft.angle, "speed_Hz": state.shaft.speed / (2.0 * np.pi)}
        for prefix, values, unit in (("", state.sensor_signal, "m"), ("i", state.current, "A"),
                                     ("exc_", injection.current, "A"), ("aux_", state.aux_position, "m"),
                                     ("bearing_", state.bearing_force, "N")):
            row.update({f"{prefix}{axis}_{unit}": getattr(values, axis) for axis in _AXES})
        for letter, end in zip("ab", contact.ends):
            row.update({f"centre_{letter}x_m": end.centre_x, f"centre_{letter}y_m": end.centre_y,
                        f"contact_{letter}x_N": end.force_x, f"contact_{letter}y_N": end.force_y,
                        f"normal_{letter}_N": end.normal_force})
        rows.append(row)
    if not rows:
        return {}
    table = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    table["tacho"] = tacho(table["t_s"], table["angle_rad"], table["speed_Hz"])
    return table


def tacho(time, angle, speed_hz):
    """One pulse a turn: rises through 0.5 where the angle is a whole turn, over two samples, and falls half a turn later."""
    import numpy as np

    step = np.gradient(time) if len(time) > 1 else np.ones_like(time)
    ramp = np.maximum(2.0 * (2.0 * np.pi * np.abs(speed_hz)) * step, 1e-12)
    place = np.pi - np.mod(np.pi - angle, 2.0 * np.pi)  # (-pi, pi]
    rising = place / ramp
    falling = np.sign(place) * (np.pi - np.abs(place)) / ramp
    signal = np.clip(0.5 + np.where(np.abs(place) <= 0.5 * np.pi, rising, falling), 0.0, 1.0)
    return np.where(speed_hz == 0.0, 0.0, signal)


def read_table(path: pathlib.Path) -> dict:
    kind = kind_of(path)
    return {".csv": read_csv, ".csv.gz": read_csv, ".npz": read_npz, ".bag": read_bag}[kind](path)


def write_table(path: pathlib.Path, table: dict) -> None:
    """Writes a table as the ending of `path` says; the file is there whole or not at all."""
    from amb_rotor.cli import common

    kind = kind_of(path)
    with common.atomic_path(path) as part:
        if kind == ".npz":
            import numpy as np
            np.savez_compressed(part, **table)
        elif kind == ".bag":
            _write_bag(part, table)
        else:
            lines = [",".join(table)]
            lines += [",".join(map(repr, row)) for row in zip(*(values.tolist() for values in table.values()))]
            data = ("\n".join(lines) + "\n").encode()
            part.write_bytes(gzip.compress(data, mtime=0) if kind == ".csv.gz" else data)


def _write_bag(path: pathlib.Path, table: dict) -> None:
    import rosbag
    import rospy
    from amb_rotor.cli import common
    from amb_rotor.errors import InputError
    from amb_rotor.msg import TableRow

    times = table.get("t_s")
    if times is None or (len(times) and times.min() <= -_STAMP_OFFSET_S):
        raise InputError(f"a bag needs the column t_s, above {-_STAMP_OFFSET_S} s")
    columns = list(table)
    rows = list(zip(*(values.tolist() for values in table.values())))
    with rosbag.Bag(str(path), "w", compression="lz4") as bag:
        for time, row in common.progress(zip(times.tolist(), rows), "writing", total=len(rows)):
            message = TableRow(columns=columns, values=list(row))
            message.header.stamp = rospy.Time.from_sec(time + _STAMP_OFFSET_S)
            bag.write(TABLE_TOPIC, message, message.header.stamp)


def run(args: argparse.Namespace) -> int:
    from amb_rotor.cli import common
    from amb_rotor.errors import InputError

    source, target = common.input_path(args.input), pathlib.Path(args.output)
    kind_of(target)
    common.require_file(target)
    table = read_table(source)
    rows = len(next(iter(table.values()))) if table else 0
    if rows == 0:
        raise InputError(f"{source}: holds no rows")
    write_table(target, table)
    common.write_json(args, {"columns": list(table), "rows": rows})
    print(f"{rows} rows of {len(table)} columns")
    common.report_line(target)
    return 0
