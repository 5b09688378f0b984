"""`amb test`: all tests, one sum."""
from __future__ import annotations

import argparse

HELP = "run all tests: GoogleTest, pytest, rostest"
EXAMPLE = "amb test --quick -k rotor"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-k", metavar="TEXT", dest="keyword", help="only tests whose name contains TEXT")
    parser.add_argument("--quick", action="store_true", help="leave out the tests that are marked slow")
    parser.add_argument("--long", action="store_true", help="also the tests that take minutes each, which are skipped else")
    parser.add_argument("--only", choices=("unit", "ros", "python"), action="append",
                        help="only GoogleTest (unit), rostest (ros) or pytest (python); may be repeated")
    parser.add_argument("--jobs", type=int, metavar="N", help="programs at a time (default: all cores)")


def run(args: argparse.Namespace) -> int:
    from amb_rotor import testing
    from amb_rotor.cli import common

    summary = testing.run_all(testing.Selection(
        keyword=args.keyword, quick=args.quick, long=args.long, kinds=tuple(args.only or testing.KINDS), jobs=args.jobs))
    common.write_json(args, summary.as_dict())
    print(summary.last_line(), flush=True)
    return 1 if summary.failed else 0
