#!/usr/bin/env python3
"""The validator beside a rig: bags of the graph are the rig, with a hidden effect and without."""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import graph_processes as graphs  # noqa: E402
import rospy  # noqa: E402
import rosunit  # noqa: E402
from amb_rotor.msg import ModelResidual  # noqa: E402
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus  # noqa: E402
from visualization_msgs.msg import MarkerArray  # noqa: E402

BELIEVED = graphs.SOURCE / "config/thesis/levitation_model.yaml"
HIDDEN = """effects:
  - effect: sensor_runout
    parameters: {a_1x_m: 3.0e-6, a_1x_phase_rad: 0.4, a_2x_m: 0.0, a_2x_phase_rad: 0.0,
                 b_1x_m: 0.0, b_1x_phase_rad: 0.0, b_2x_m: 0.0, b_2x_phase_rad: 0.0}
"""
SCENARIO = """format: amb-scenario/1
name: steady
duration_s: 0.5
record_rate_hz: 10000.0
speed: {type: constant, start_hz: 60.0, initial_angle_rad: 0.0}
excitations: []
faults: []
start: settled
"""
BLOCKS = 5  # of 0.1 s
PATIENCE_S = 80.0


class Listener:
    """What the validator says while a bag is played."""

    def __init__(self):
        self.residuals, self.levels, self.texts, self.markers = [], [], [], None
        self.subscribers = [rospy.Subscriber("/validator/residual", ModelResidual, self.residuals.append),
                            rospy.Subscriber("/validator/markers", MarkerArray, self.take_markers),
                            rospy.Subscriber("/diagnostics", DiagnosticArray, self.take_status)]

    def take_markers(self, message):
        self.markers = message

    def take_status(self, message):
        for status in message.status:
            if status.name.endswith("model against rig"):
                self.levels.append(status.level if isinstance(status.level, int) else ord(status.level))
                self.texts.append(status.message)

    def close(self):
        for subscriber in self.subscribers:
            subscriber.unregister()


class ValidatorTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("validator_test")
        cls.folder = tempfile.TemporaryDirectory()
        path = pathlib.Path(cls.folder.name)
        (path / "steady.yaml").write_text(SCENARIO)
        text = BELIEVED.read_text()
        assert text.rstrip().endswith("effects: []")
        (path / "other.yaml").write_text(text.replace("effects: []", HIDDEN))
        cls.bags = {}
        for name, model in (("as_believed", BELIEVED), ("hidden", path / "other.yaml")):
            cls.bags[name] = path / f"{name}.bag"
            status, output = graphs.amb("launch", path / "steady.yaml", "--model", model, "--rate", "0", "--record",
                                        cls.bags[name], seconds=120)
            assert status == 0, output

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def play(self, name):
        listener = Listener()
        log = open(pathlib.Path(self.folder.name) / f"{name}.log", "w+")
        launch = subprocess.Popen(graphs.roslaunch("validator.launch", f"model:={BELIEVED}", f"bag:={self.bags[name]}",
                                                   "rate:=0"), env=dict(os.environ), stdout=log, stderr=subprocess.STDOUT)
        try:
            end = time.monotonic() + PATIENCE_S
            while len(listener.residuals) < BLOCKS and time.monotonic() < end and launch.poll() is None:
                time.sleep(0.1)
            seen = len(listener.levels)
            while len(listener.levels) < seen + 2 and time.monotonic() < end:  # the diagnostics after the last block
                time.sleep(0.1)
        finally:
            launch.send_signal(signal.SIGINT)
            launch.wait(30)
            listener.close()
        log.seek(0)
        self.assertEqual(len(listener.residuals), BLOCKS, log.read()[-3000:])
        return listener

    def test_the_believed_rig_holds(self):
        listener = self.play("as_believed")
        self.assertFalse(listener.residuals[0].judged)
        self.assertEqual(listener.residuals[0].regime, "settling")
        for residual in listener.residuals[1:]:
            self.assertTrue(residual.judged)
            self.assertEqual(residual.regime, "steady")
            # the bag holds no noise: what is left is what the lanes' steps differ by, far below the stated noise
            self.assertLess(residual.error, 0.2)
            self.assertFalse(residual.left)
            self.assertAlmostEqual(residual.speed, 60.0, places=6)
        self.assertEqual(set(listener.levels), {DiagnosticStatus.OK}
                         if isinstance(DiagnosticStatus.OK, int) else {ord(DiagnosticStatus.OK)})
        self.assertEqual(listener.residuals[-1].blocks, BLOCKS - 1)

    def test_a_hidden_effect_raises(self):
        listener = self.play("hidden")
        lefts = [residual.left for residual in listener.residuals]
        self.assertEqual(lefts, [False] * 3 + [True] * (BLOCKS - 3))  # one settles, three are the patience
        last = listener.residuals[-1]
        self.assertGreater(last.error, 1.5)
        self.assertGreater(last.channel_error[0], 2.0 * last.channel_error[2])  # end a, where the runout is
        self.assertEqual(listener.levels[-1], 2)
        self.assertIn("the model has been left", listener.texts[-1])
        self.assertEqual(last.gaps, 0)
        # rviz shows both orbits at both ends, and they differ
        shown = {(m.ns, m.id): m for m in listener.markers.markers}
        for end in (0, 1):
            self.assertEqual(len(shown["measured_orbit", end].points), 1000)
            self.assertEqual(len(shown["predicted_orbit", end].points), 1000)
        apart = max(abs(a.x - b.x) for a, b in zip(shown["measured_orbit", 0].points, shown["predicted_orbit", 0].points))
        scale = 0.05 / 0.3e-3  # as drawn: the clearance is 0.05 m
        self.assertGreater(apart, 0.5e-6 * scale)


if __name__ == "__main__":
    rosunit.unitrun("amb_rotor", "validator", ValidatorTest)
