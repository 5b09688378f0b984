"""What the subcommands share: where output goes, files that appear whole, progress, children that end."""
from __future__ import annotations

import argparse
import contextlib
import errno
import json
import math
import os
import pathlib
import secrets
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from typing import Any, Callable, Iterable, Iterator, NoReturn

from amb_rotor.errors import InputError


def input_path(text: str) -> pathlib.Path:
    """The path of an existing file or folder, as an argument."""
    path = pathlib.Path(text)
    if not path.exists():
        raise InputError(f"{text}: there is no such file or folder")
    if not (path.is_file() or path.is_dir() or path.is_fifo()):  # a device may never end
        raise InputError(f"{text}: is neither a file nor a folder")
    return path


def require_writable(path: pathlib.Path) -> None:
    """Before long work: that a file or folder of this name can be made. Nothing is left."""
    missing = [folder for folder in path.parents if not os.path.exists(folder)]  # the deepest first
    probe = path.with_name(f".{secrets.token_hex(4)}.part.{path.name}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        there = next(folder for folder in path.parents if os.path.exists(folder))
        reason = f"{there} is a file" if not there.is_dir() else \
            f"nothing can be made in {there}" if error.errno == errno.ENOENT else error.strerror
        raise InputError(f"{path}: cannot be written: {reason}") from None
    finally:
        for folder in missing:
            with contextlib.suppress(OSError):
                folder.rmdir()


def require_file(path: pathlib.Path) -> None:
    """Before long work: that a file of this name can be written, whose folder need not be there."""
    if os.path.isdir(path):
        raise InputError(f"{path}: is a folder; it must be a file to write")
    if not _is_stream(path):
        require_writable(path)


def require_folder(folder: pathlib.Path) -> None:
    """Before long work: that files can be written to this folder, which need not be there."""
    if os.path.exists(folder) and not folder.is_dir():
        raise InputError(f"{folder}: is a file; it must be a folder to write to")
    try:
        require_writable(folder / "x")
    except InputError as error:
        raise InputError(str(error).replace(str(folder / "x"), str(folder), 1)) from None


def dataset_folder(text: str) -> pathlib.Path:
    """The folder of a data set, as an argument; its dataset.yaml stands for it."""
    path = input_path(text)
    folder = path.parent if path.name == "dataset.yaml" else path
    if not folder.is_dir():
        raise InputError(f"{path}: is a file; a data set is a folder with dataset.yaml and a table for each run (doc/formats.md)")
    if not (folder / "dataset.yaml").is_file():
        inside = sorted(child.name for child in folder.iterdir() if (child / "dataset.yaml").is_file())
        known = f"; data sets in it: {', '.join(inside[:8])}{' ...' if len(inside) > 8 else ''}" if inside else \
            ", which says what its tables hold (doc/formats.md)"
        raise InputError(f"{folder}: is no data set: there is no dataset.yaml in it{known}")
    return folder


def add_out(parser: argparse.ArgumentParser, command: str) -> None:
    """`--out DIR` with the default of all subcommands that write a folder."""
    parser.add_argument("--out", metavar="DIR",
                        help=f"folder for what is written (default: out/{command}-NAME)")


def out_path(args: argparse.Namespace, command: str, name: str) -> pathlib.Path:
    """The folder to write to: `--out`, or out/COMMAND-NAME in the caller's folder. Refused where that cannot be; not made yet, so that
    what fails leaves none."""
    folder = pathlib.Path(args.out) if args.out else pathlib.Path("out") / f"{command}-{name}"
    require_folder(folder)
    return folder


def out_folder(args: argparse.Namespace, command: str, name: str) -> pathlib.Path:
    """The same, made."""
    folder = out_path(args, command, name)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def report_line(path: os.PathLike | str) -> None:
    """The last line of a subcommand's output: names what it wrote."""
    print(f"report: {path}", flush=True)


def _is_stream(path: pathlib.Path) -> bool:
    """A pipe, a device, or a name that the system gives an open file: its place must not be taken."""
    return os.path.exists(path) and not os.path.isdir(path) and \
        (not os.path.isfile(path) or os.path.abspath(path).startswith(("/dev/", "/proc/")))


@contextlib.contextmanager
def atomic_path(path: os.PathLike | str) -> Iterator[pathlib.Path]:
    """A path beside `path` to write to. It takes the name `path` when the block ends, and goes if it fails."""
    target = pathlib.Path(path)
    if _is_stream(target):
        with tempfile.TemporaryDirectory() as folder:
            yield pathlib.Path(folder) / target.name
            target.write_bytes((pathlib.Path(folder) / target.name).read_bytes())
        return
    # The suffix stays last: writers such as numpy.savez look at it.
    part = target.with_name(f".{secrets.token_hex(4)}.part.{target.name}")
    try:
        yield part
        os.replace(part, target)
    except OSError as error:
        error.filename = error.filename or os.fspath(target)  # a full disk does not say by itself whose it is
        raise
    finally:
        part.unlink(missing_ok=True)


def atomic_write(path: os.PathLike | str, content: str | bytes) -> None:
    """Writes a file that is there whole or not at all."""
    with atomic_path(path) as part:
        part.write_bytes(content.encode() if isinstance(content, str) else content)


@contextlib.contextmanager
def atomic_paths() -> Iterator[Callable[[os.PathLike | str], pathlib.Path]]:
    """Files that change together: yields a function that gives the path to write a file to, beside it. All take their names when
    the block ends; where it fails, or one of them cannot take its name, every file is as it was."""
    parts: dict[pathlib.Path, pathlib.Path] = {}
    kept: dict[pathlib.Path, pathlib.Path] = {}  # what stood there
    named: list[pathlib.Path] = []

    def beside(target: pathlib.Path, word: str) -> pathlib.Path:
        return target.with_name(f".{secrets.token_hex(4)}.{word}.{target.name}")

    def part_of(path: os.PathLike | str) -> pathlib.Path:
        target = pathlib.Path(path)
        return parts.setdefault(target, beside(target, "part"))

    try:
        yield part_of
        for target in filter(os.path.exists, parts):
            kept[target] = beside(target, "old")
            shutil.copy2(target, kept[target])
        for target, part in parts.items():
            named.append(target)
            os.replace(part, target)
    except BaseException as error:
        if isinstance(error, OSError):
            error.filename = error.filename or os.fspath(next(iter(parts), ""))
        for target in named:
            if target in kept:
                os.replace(kept[target], target)
            else:
                target.unlink(missing_ok=True)
        raise
    finally:
        for path in [*parts.values(), *kept.values()]:
            path.unlink(missing_ok=True)


@contextlib.contextmanager
def atomic_folder(folder: pathlib.Path) -> Iterator[pathlib.Path]:
    """A folder to fill. It takes the name `folder` when the block ends, and goes if it fails. Where `folder` is there already, it
    keeps what it holds, and the new files get their names in it together or not at all."""
    there = folder.is_dir()
    name = f".{secrets.token_hex(4)}.part."
    part = folder / name if there else folder.with_name(name + folder.name)  # inside: of the same disk, wherever a link leads
    missing = [] if there else [parent for parent in folder.parents if not parent.exists()]  # the deepest first
    done = False
    try:
        part.mkdir(parents=True)
        yield part
        if there:
            _move_into(part, folder)
        else:
            os.replace(part, folder)
        done = True
    finally:
        for _ in range(100):  # a thread may write yet
            shutil.rmtree(part, ignore_errors=True)
            if not part.exists():
                break
        for parent in missing if not done else []:
            with contextlib.suppress(OSError):
                parent.rmdir()


def _move_into(part: pathlib.Path, folder: pathlib.Path) -> None:
    files = [path.relative_to(part) for path in sorted(part.rglob("*")) if path.is_file()]
    made = []
    try:
        for inner in sorted({parent for file in files for parent in file.parents}):  # outer ones first
            if not (folder / inner).is_dir():
                (folder / inner).mkdir()
                made.append(folder / inner)
        with atomic_paths() as part_of:
            for file in files:
                os.replace(part / file, part_of(folder / file))
    except BaseException:
        for inner in reversed(made):
            with contextlib.suppress(OSError):
                inner.rmdir()
        raise


def on_thread(call: Callable[[], Any]) -> Any:
    """What `call` returns or raises, from a thread of its own: a long call of the core hears no signals, this one waits and does.
    Where one comes the call goes on, and only the end of the process ends it: `end_at_once`."""
    outcome: dict[str, Any] = {}
    over = threading.Event()

    def work() -> None:
        try:
            outcome["value"] = call()
        except BaseException as error:
            outcome["error"] = error
        over.set()

    threading.Thread(target=work, daemon=True).start()
    over.wait()
    if "error" in outcome:
        raise outcome["error"]
    return outcome["value"]


def end_at_once(command: str, stop: BaseException) -> NoReturn:
    """Ends the process although a thread is in the core, as Ctrl-C or SIGTERM end any command."""
    if not isinstance(stop, SystemExit):
        print(f"amb {command}: interrupted", file=sys.stderr, flush=True)
    sys.stdout.flush()
    os._exit(stop.code if isinstance(stop, SystemExit) else 128 + signal.SIGINT)


def _plain(value: Any) -> Any:
    """numpy's numbers and arrays as Python's, and NaN as null: JSON has no NaN."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    return value


def write_json(args: argparse.Namespace, result: Any) -> None:
    """Writes the result where `--json` says; nothing where it is not given."""
    if not args.json:
        return
    text = json.dumps(_plain(result), indent=2, allow_nan=False) + "\n"
    if args.json == "-":
        getattr(args, "json_stream", sys.stdout).write(text)
    else:
        atomic_write(args.json, text)


def progress(items: Iterable, description: str, total: int | None = None) -> Iterable:
    """A progress bar over `items` on stderr; none when stderr is not a terminal, or work ends in a second."""
    if not sys.stderr.isatty():
        return items
    from tqdm import tqdm
    return tqdm(items, desc=description, total=total, delay=1.0, leave=False)


def progress_bar(total: int, description: str):
    """The same for work that is not a loop: has update(n) and close(), and is a context manager."""
    from tqdm import tqdm
    return tqdm(total=total, desc=description, delay=1.0, leave=False, disable=not sys.stderr.isatty())


def end_group(process: subprocess.Popen, patience: float = 10.0) -> None:
    """Ends a child and all that it started: asks first, then kills."""
    for signum, seconds in ((signal.SIGINT, patience), (signal.SIGTERM, 3.0), (signal.SIGKILL, None)):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signum)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(seconds)
            break
    # What the child started may outlive it.
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)


@contextlib.contextmanager
def child(command: list, patience: float = 10.0, **options) -> Iterator[subprocess.Popen]:
    """A child process in a group of its own; however the block ends, the whole group is gone after it.

    A group of its own does not see the terminal's Ctrl-C: we do, and pass it on in order.
    """
    options.setdefault("stdin", subprocess.DEVNULL)
    process = subprocess.Popen([os.fspath(part) for part in command], start_new_session=True, **options)
    try:
        yield process
    finally:
        end_group(process, patience)
