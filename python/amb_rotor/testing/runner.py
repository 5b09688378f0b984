"""Runs the programs, prints as they end, and sums up."""
from __future__ import annotations

import concurrent.futures
import os
import shutil
import subprocess
import threading
import time

from amb_rotor import paths
from amb_rotor.cli.common import child
from amb_rotor.testing import programs as collect
from amb_rotor.testing.programs import Program, Selection, tail
from amb_rotor.testing.results import FAILED, PASSED, SKIPPED, Result, Summary


class _Stop:
    """Ends the programs of other threads when this run is interrupted."""

    def __init__(self):
        self.event = threading.Event()

    def wait(self, process: subprocess.Popen, seconds: float) -> bool:
        """True when the process ended by itself within the time."""
        deadline = time.monotonic() + seconds
        while process.poll() is None:
            if self.event.wait(0.05) or time.monotonic() > deadline:
                return False
        return True


def _run_program(program: Program, root, stop: _Stop) -> list[Result]:
    started = time.monotonic()
    limit = collect.TIME_LIMIT[program.kind]
    if stop.event.is_set():
        return []
    shutil.rmtree(program.folder, ignore_errors=True)
    program.folder.mkdir(parents=True)
    # The output goes to a file: a grandchild that keeps a pipe open would hold us up for ever.
    log = program.folder / "output.log"
    with open(log, "wb") as stream, child(program.command, cwd=root, stdout=stream,
                                          stderr=subprocess.STDOUT,
                                          env={**os.environ, **program.environment}) as process:
        in_time = stop.wait(process, limit)
    output = log.read_text(errors="replace")
    seconds = time.monotonic() - started
    if stop.event.is_set():
        return []
    if not in_time:
        running = f"ended after {limit} s\n{tail(output)}"
        return [*_finished_before_timeout(program), Result(program.name, "(time limit)", FAILED, seconds, running)]
    return program.read(process.returncode, output)


def _finished_before_timeout(program: Program) -> list[Result]:
    """What the program managed to write before it was ended; often nothing."""
    try:
        return program.read(0, "")
    except Exception:  # a half-written file: the time limit is reported anyway
        return []


def _print_program(name: str, results: list[Result], seconds: float) -> None:
    counts = Summary(results)
    parts = [f"{counts.count(outcome)} {outcome}" for outcome in (PASSED, FAILED, SKIPPED)
             if counts.count(outcome)]
    print(f"  {name:<36} {', '.join(parts) or 'no test selected':<32} {seconds:6.1f} s", flush=True)


def _print_skipped(summary: Summary) -> None:
    by_reason: dict[str, list[str]] = {}
    for result in summary.results:
        if result.outcome == SKIPPED:
            by_reason.setdefault(result.message or "no reason given", []).append(result.name)
    if by_reason:
        print("\nskipped:")
    for reason, names in by_reason.items():
        shown = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
        print(f"  {shown}: {reason}")


def _print_failed(summary: Summary) -> None:
    for result in summary.results:
        if result.outcome == FAILED:
            print(f"\nFAILED {result.program}: {result.name}\n{result.message.strip()}")


def _gather(selection: Selection, jobs: int) -> tuple[list[Program], list[Result]]:
    root, build = paths.share_folder(), paths.build_folder()
    folder = build / "test_results"
    programs: list[Program] = []
    skipped: list[Result] = []
    if "python" in selection.kinds:  # first: it is the longest, and runs beside the others
        programs += collect.python_tests(root, folder, selection)
    if "unit" in selection.kinds:
        programs += collect.google_tests(build, folder, selection, jobs)
    if "ros" in selection.kinds:
        ros_programs, skipped = collect.ros_tests(root, build, folder, selection)
        programs += ros_programs
    return programs, skipped


def run_all(selection: Selection) -> Summary:
    """Runs the selected tests: pytest and GoogleTest on all cores, then the rostests one by one."""
    jobs = selection.jobs or os.cpu_count() or 1
    programs, skipped = _gather(selection, jobs)
    summary = Summary(list(skipped))
    stop = _Stop()
    root = paths.share_folder()
    if selection.quick:
        os.environ["AMB_ROTOR_QUICK"] = "1"

    def run(program: Program) -> tuple[list[Result], float]:
        started = time.monotonic()
        return _run_program(program, root, stop), time.monotonic() - started

    def finish(program: Program, results: list[Result], seconds: float) -> None:
        summary.results.extend(results)
        _print_program(program.name, results, seconds)

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        try:
            together = {pool.submit(run, program): program for program in programs if not program.alone}
            for future in concurrent.futures.as_completed(together):
                finish(together[future], *future.result())
            for program in programs:
                if program.alone:
                    finish(program, *pool.submit(run, program).result())
        except BaseException:
            stop.event.set()
            pool.shutdown(cancel_futures=True)
            raise

    _print_skipped(summary)
    _print_failed(summary)
    print()
    return summary
