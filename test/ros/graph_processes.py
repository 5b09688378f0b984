"""Runs whole graphs as a person does, each at a master of its own, and leaves no process behind."""
import os
import pathlib
import signal
import subprocess
import sys

from amb_rotor.ports import free_port

SOURCE = pathlib.Path(os.environ.get("AMB_ROTOR_ROOT", pathlib.Path(__file__).resolve().parents[2]))


def environment(**more):
    """Ours, with a master at a free port."""
    return {**os.environ, "ROS_MASTER_URI": f"http://localhost:{free_port()}", "ROS_HOSTNAME": "localhost", **more}


def amb(*arguments, seconds=90, env=None):
    """`amb ARGUMENTS`: exit status and output."""
    done = subprocess.run([sys.executable, "-P", "-m", "amb_rotor", *map(str, arguments)], timeout=seconds, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=env or environment(), check=False)
    return done.returncode, done.stdout


def roslaunch(name, *arguments):
    return [sys.executable, "-P", "/usr/bin/roslaunch", "--sigint-timeout=8", "--sigterm-timeout=2",
            str(SOURCE / "launch" / name), *arguments]


def run_launch(name, *arguments, seconds=60):
    """A launch file to its end, by itself or by us: roslaunch that is killed would leave its nodes behind."""
    process = subprocess.Popen(roslaunch(name, *arguments), env=environment(), text=True, errors="replace",
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    try:
        output, _ = process.communicate(timeout=seconds)
        return process.returncode, output
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate(timeout=30)
        return None, output


def left_over(mark):
    """Command lines of living processes that hold the mark."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            command = (process / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
        except OSError:
            continue
        if mark in command and int(process.name) != os.getpid():
            found.append(command)
    return found
