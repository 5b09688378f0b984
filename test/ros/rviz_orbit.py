#!/usr/bin/env python3
"""rviz, rendered without a screen, shows the orbit of an overload: its trail in both colours, at both ends."""
import contextlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import graph_processes as graphs  # noqa: E402
import rosunit  # noqa: E402
from PIL import Image, ImageGrab  # noqa: E402

# src/ros/orbit_markers.cpp
COLOURS = {"free trail": (0, 153, 255), "trail in contact": (255, 77, 0), "clearance circle": (26, 179, 51),
           "Poincare points": (230, 0, 204)}
LEAST = {"free trail": 150, "trail in contact": 150, "clearance circle": 150, "Poincare points": 5}
COLOUR_TOLERANCE = 40  # of 255, each channel: lines are thin, and blend with what is behind them
LEAST_WIDTH = 60       # pixels that the trail spans
# rviz itself aborts at its start now and then (one in eleven here, by its heap): it is begun again, so many times in all
ATTEMPTS, DIED = 3, re.compile(r"\[rviz-\d+\] process has died")
PATIENCE_S = 45.0


def pixels(image, colour):
    """Places of the pixels of about that colour."""
    width = image.width
    return [(i % width, i // width) for i, pixel in enumerate(image.convert("RGB").getdata())
            if all(abs(a - b) <= COLOUR_TOLERANCE for a, b in zip(pixel, colour))]


def missing(image):
    """What is not drawn, of all that should be."""
    faults = []
    for name, colour in COLOURS.items():
        places = pixels(image, colour)
        if len(places) < LEAST[name]:
            faults.append(f"{name}: {len(places)} pixels")
        elif "trail" in name and max(x for x, _ in places) - min(x for x, _ in places) < LEAST_WIDTH:
            faults.append(f"{name}: too narrow")
    return faults


@contextlib.contextmanager
def screen():
    """A display of our own; yields its name."""
    read, write = os.pipe()
    server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1200x800x24", "-nolisten", "tcp"],
                              pass_fds=[write], stderr=subprocess.DEVNULL)
    try:
        os.close(write)
        with os.fdopen(read) as answer:
            number = answer.readline().strip()
        if not number:
            raise RuntimeError("Xvfb did not start")
        yield f":{number}"
    finally:
        server.terminate()
        server.wait()


class Rviz(unittest.TestCase):
    def test_an_empty_picture_shows_nothing(self):
        self.assertEqual(len(missing(Image.new("RGB", (400, 300), (245, 245, 245)))), len(COLOURS))

    @unittest.skipUnless(shutil.which("Xvfb") and shutil.which("rviz"), "Xvfb and rviz are not installed")
    def test_the_orbit_is_drawn(self):
        for _ in range(ATTEMPTS):
            faults, log = self.look()
            if not faults or not DIED.search(log):
                break
        self.assertEqual(faults, [], log[-3000:])

    def look(self):
        """What is missing in the picture, and what the launch printed."""
        keep = os.environ.get("AMB_ROTOR_PICTURE")  # a person who wants to see it
        with tempfile.TemporaryDirectory() as folder, screen() as display:
            path = pathlib.Path(folder) / "log"
            environment = graphs.environment(DISPLAY=display, LIBGL_ALWAYS_SOFTWARE="1", QT_X11_NO_MITSHM="1",
                                             XDG_RUNTIME_DIR=folder)
            with open(path, "w") as log:
                launch = subprocess.Popen(
                    graphs.roslaunch("overload.launch", "rviz:=true", "rate:=0", "exit_at_end:=false"),
                    env=environment, stdout=log, stderr=subprocess.STDOUT, start_new_session=True)
            try:
                faults, end = ["nothing yet"], time.monotonic() + PATIENCE_S
                while (faults and time.monotonic() < end and launch.poll() is None
                       and not DIED.search(path.read_text(errors="replace"))):
                    time.sleep(1.0)
                    image = ImageGrab.grab(xdisplay=display)
                    faults = missing(image)
                if keep:
                    time.sleep(8.0)
                    ImageGrab.grab(xdisplay=display).save(keep)
            finally:
                launch.send_signal(2)
                launch.wait(30)
            return faults, path.read_text(errors="replace")


if __name__ == "__main__":
    rosunit.unitrun("amb_rotor", "rviz_orbit", Rviz)
