#!/usr/bin/env python3
"""A recorded run is whole, and played back it gives the same analysis as live. `amb launch` makes it."""
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import graph_processes as graphs  # noqa: E402
import rosbag  # noqa: E402
import rosunit  # noqa: E402

ANALYSIS = ("/analysis/orbit", "/analysis/poincare", "/analysis/spectrum")


def messages(bag, topics):
    """Texts of the messages by topic, without the sequence number that a publisher counts."""
    found = {topic: [] for topic in topics}
    with rosbag.Bag(str(bag)) as opened:
        for topic, message, _ in opened.read_messages(topics=topics):
            found[topic].append(re.sub(r"^(\s*seq:) \d+", r"\1", str(message), flags=re.MULTILINE))
    return found


class Replay(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def test_replay_gives_the_analysis_of_the_live_run(self):
        live, again = self.path / "live.bag", self.path / "again.bag"
        status, output = graphs.amb("launch", "overload", "--rate", "0", "--record", live)
        self.assertEqual(status, 0, output)
        self.assertTrue(output.strip().endswith(f"report: {live}"), output)
        self.check_whole(live)
        self.assertEqual(graphs.left_over(str(live)), [])

        status, output = graphs.run_launch("replay.launch", f"bag:={live}", f"record:={again}", "rate:=0", "rviz:=false",
                                           "exit_at_end:=true")
        self.assertEqual(status, 0, output)
        self.assertTrue(again.exists(), output)
        first, second = messages(live, ANALYSIS), messages(again, ANALYSIS)
        for topic in ANALYSIS:
            self.assertGreater(len(first[topic]), 1, topic)
            self.assertEqual(first[topic], second[topic], topic)

    def check_whole(self, bag):
        """Every step with its three answers, at simulated time."""
        steps = {topic: [] for topic in ("/rotor/state", "/controller/command", "/auxiliary_bearing/contact",
                                         "/injector/injection")}
        with rosbag.Bag(str(bag)) as opened:
            for topic, message, stamp in opened.read_messages(topics=list(steps)):
                steps[topic].append(message.step)
                if topic == "/rotor/state":
                    self.assertAlmostEqual(stamp.to_sec(), message.time + 1.0, places=6)
            self.assertEqual(opened.get_message_count("/rotor/model"), 1)
        for topic, numbers in steps.items():
            self.assertEqual(sorted(set(numbers)), list(range(5001)), topic)

    def test_ctrl_c_leaves_no_process(self):
        scenario = self.path / "unending.yaml"
        text = (graphs.SOURCE / "config/thesis/levitation.yaml").read_text()
        scenario.write_text(text.replace("duration_s: 0.5", "duration_s: 1000.0"))
        process = subprocess.Popen([sys.executable, "-P", "-m", "amb_rotor", "launch", str(scenario)],
                                   env=graphs.environment(ROS_LOG_DIR=str(self.path / "log")),
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        nodes = str(self.path / "log")  # is in the command line of each node
        end = time.monotonic() + 20.0
        while len(graphs.left_over(nodes)) < 5 and time.monotonic() < end:
            time.sleep(0.1)
        self.assertGreaterEqual(len(graphs.left_over(nodes)), 5)
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=40)
        self.assertEqual(process.returncode, 128 + signal.SIGINT, errors)
        self.assertEqual(graphs.left_over(str(scenario)) + graphs.left_over(nodes), [])

    def test_a_fault_by_rostopic(self):
        bag = self.path / "fault.bag"
        env = graphs.environment()
        # what a person types, in another terminal; it waits for the master and for the injector (asked while the master starts,
        # rosnode may wait for ever) and has to be there before the run has ended
        person = subprocess.Popen(
            ["/bin/sh", "-c", "until timeout 3 rosnode list 2>/dev/null | grep -q injector; do sleep 0.2; done; "
             "rostopic pub -1 /fault amb_rotor/Fault '{type: 2, end: 1, start: 0.05, duration: 0.01}'"],
            env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            status, output = graphs.amb("launch", "levitation", "--rate", "0.03", "--record", bag, env=env)
            person.wait(20)
        finally:
            person.kill()
        self.assertEqual(status, 0, output)
        with rosbag.Bag(str(bag)) as opened:
            injections = [m for _, m, _ in opened.read_messages(topics=["/injector/injection"])]
        self.assertEqual(len(injections[-1].faults), 1)
        start = injections[-1].faults[0].start
        off = [m for m in injections if not m.bearing_on[0]]
        self.assertTrue(off and all(list(m.bearing_on) == [False, False, True, True] for m in off))
        self.assertAlmostEqual(off[0].header.stamp.to_sec() - 1.0, start, places=6)
        self.assertAlmostEqual(off[-1].valid_until, start + 0.01, places=6)

    def test_bad_input_is_one_message(self):
        status, output = graphs.amb("launch", "no-such-scenario")
        self.assertEqual(status, 2)
        self.assertIn("no such file", output)
        self.assertNotIn("Traceback", output)


if __name__ == "__main__":
    rosunit.unitrun("amb_rotor", "bag_replay", Replay)
