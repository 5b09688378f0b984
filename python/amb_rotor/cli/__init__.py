"""The command line `amb SUBCOMMAND ...`: finds the subcommand's module, parses, runs, reports errors.

A subcommand is a module `amb_rotor.cli.MODULE` with

    HELP      one line for the list of subcommands
    EXAMPLE   a command line that works
    add_arguments(parser)   its arguments (`--json FILE` is there already; see `common` for `--out`)
    run(args) -> int        exit status: 0 done, 1 a check failed; bad input raises InputError (2)

The list of subcommands imports every module, and help must work before anything is built: a module
imports numpy, amb_rotor._core, rospy and the like inside run(), not at its top.
"""
from __future__ import annotations

import argparse
import contextlib
import errno
import importlib
import importlib.util
import os
import pathlib
import re
import signal
import sys
import traceback

import amb_rotor
from amb_rotor.errors import InputError

# Subcommand -> module, in the order of the help. One that has no module yet is left out of the list.
COMMANDS = {
    "demo": "demo",
    "test": "test",
    "simulate": "simulate",
    "launch": "launch",
    "modes": "modes",
    "campbell": "campbell",
    "critical-speeds": "critical_speeds",
    "margins": "margins",
    "reduce": "reduce",
    "analyse": "analyse",
    "sweep": "sweep",
    "continue": "continuation",
    "identify": "identify",
    "compare": "compare",
    "diagnose": "diagnose",
    "adopt": "adopt",
    "new-effect": "new_effect",
    "convert": "convert",
    "check": "check",
    "bench": "bench",
    "make-dataset": "make_dataset",
    "bench-diagnosis": "bench_diagnosis",
}

EXIT_DONE = 0
EXIT_CHECK_FAILED = 1
EXIT_BAD_INPUT = 2
# What a file or a disk does to us: no file, no right, full, too long a name ...
_FILE_ERRORS = {errno.ENOENT, errno.EACCES, errno.EPERM, errno.EISDIR, errno.ENOTDIR, errno.ENOTEMPTY, errno.EEXIST, errno.ENOSPC,
                errno.EFBIG, errno.EDQUOT, errno.EROFS, errno.ENAMETOOLONG, errno.ELOOP, errno.EIO, errno.ENXIO}
EXIT_DEFECT = 3  # an exception that is no fault of the input: a traceback, and a status of its own


def available_commands() -> dict[str, str]:
    """Subcommand -> full module name, for the modules that exist."""
    modules = {command: f"amb_rotor.cli.{module}" for command, module in COMMANDS.items()}
    return {command: module for command, module in modules.items() if importlib.util.find_spec(module)}


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one message; argparse's exit status for bad arguments is 2 already."""

    def error(self, message: str):
        self.exit(EXIT_BAD_INPUT, f"{self.prog}: {message}\n(try `{self.prog} --help`)\n")


def _top_parser() -> argparse.ArgumentParser:
    lines = [f"  {command:<16} {importlib.import_module(module).HELP}"
             for command, module in available_commands().items()]
    return _Parser(
        prog="amb", usage="amb SUBCOMMAND [ARGUMENT ...]",
        description="Rotors on active magnetic bearings: simulate, analyse, compare with measurements, "
                    "find the physics that a model lacks.\n\nsubcommands:\n" + "\n".join(lines),
        epilog="`amb SUBCOMMAND --help` shows its arguments and an example.",
        formatter_class=argparse.RawDescriptionHelpFormatter)


def _command_parser(command: str, module) -> argparse.ArgumentParser:
    parser = _Parser(
        prog=f"amb {command}", description=module.HELP, epilog=f"example:\n  {module.EXAMPLE}",
        formatter_class=argparse.RawDescriptionHelpFormatter)
    module.add_arguments(parser)
    parser.add_argument("--json", metavar="FILE", help="write the result for machines; - is stdout")
    return parser


def _report_bad_input(command: str, message: str) -> int:
    # files are written beside: they are told by their own names
    message = re.sub(r"\.[0-9a-f]{8}\.(?:part|old)\./?", "", message)
    print(f"amb {command}: {message}", file=sys.stderr)
    return EXIT_BAD_INPUT


def _report_defect(command: str) -> int:
    traceback.print_exc()
    print(f"amb {command}: this is a defect of amb_rotor, not of the input", file=sys.stderr)
    return EXIT_DEFECT


def _terminate(signum, _frame):
    """SIGTERM and SIGHUP unwind the stack like Ctrl-C, so that children end and part files go."""
    raise SystemExit(128 + signum)


def _require_json(text: str) -> None:
    """That the result can be written: told before the work, not after it."""
    from amb_rotor.cli import common
    target = pathlib.Path(text)
    if not target.parent.is_dir():
        raise InputError(f"--json {text}: there is no such folder to write to")
    try:
        common.require_file(target)
    except InputError as error:
        raise InputError(f"--json {error}") from None


def _call(module, args) -> int:
    """Runs the subcommand. With `--json -` stdout holds the result alone: what is for people goes to stderr."""
    if args.json and args.json != "-":
        _require_json(args.json)
    if args.json != "-":
        return int(module.run(args) or EXIT_DONE)
    args.json_stream = sys.stdout
    with contextlib.redirect_stdout(sys.stderr):
        return int(module.run(args) or EXIT_DONE)


def _run(command: str, module, args) -> int:
    try:
        return _call(module, args)
    except InputError as error:
        return _report_bad_input(command, str(error))
    except KeyboardInterrupt:
        print(f"amb {command}: interrupted", file=sys.stderr)
        return 128 + signal.SIGINT
    except BrokenPipeError:
        # The reader of our output went away (`amb ... | head`): not an error, and no second message
        # from the interpreter when it flushes.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 128 + signal.SIGPIPE
    except OSError as error:
        if error.errno not in _FILE_ERRORS:
            return _report_defect(command)
        return _report_bad_input(command, f"{error.filename}: {error.strerror}")
    except Exception:
        return _report_defect(command)


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line and returns its exit status."""
    arguments = sys.argv[1:] if arguments is None else list(arguments)
    for signum in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(signum, _terminate)
    if hasattr(sys.stdout, "reconfigure"):
        sys.stdout.reconfigure(errors="backslashreplace")  # a name that the terminal cannot show is no reason to stop

    if not arguments or arguments[0] in ("-h", "--help"):
        stream = sys.stdout if arguments else sys.stderr
        _top_parser().print_help(stream)
        return EXIT_DONE if arguments else EXIT_BAD_INPUT
    if arguments[0] == "--version":
        print(f"amb_rotor {amb_rotor.__version__}")
        return EXIT_DONE

    command = arguments[0]
    modules = available_commands()
    if command not in modules:
        print(f"amb: there is no subcommand {command!r}; there are: {', '.join(modules)}", file=sys.stderr)
        return EXIT_BAD_INPUT
    module = importlib.import_module(modules[command])
    try:
        args = _command_parser(command, module).parse_args(arguments[1:])
    except SystemExit as stop:  # argparse: --help, or a message that is printed already
        return int(stop.code or 0)
    return _run(command, module, args)
