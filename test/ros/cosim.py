#!/usr/bin/python3
"""Rig, wheel and discrete-element soil as three nodes in lock-step: as nodelets and as processes the same numbers to the bit as
`twin run --fidelity dem` in one process; a side that dies or stalls stops the others with one line, the bag is closed and
readable, and the run goes on from its checkpoint to the same numbers."""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

import rospy
import rostest
from ros_helpers import LIMIT, TOPICS, Collector, Process, call, launch, program, read
from std_msgs.msg import String
from std_srvs.srv import Trigger

SETTINGS = str(pathlib.Path(__file__).resolve().parent / "cosim" / "small.yaml")
CACHE = os.path.join(os.environ["ROS_HOME"], "beds")


def plain(content):
    """Values without stamps."""
    return {topic: [v[2:] for v in values] for topic, values in content.items()}


def side(kind, name, *arguments):
    """A node of the co-simulation as a process of its own."""
    return Process(program("wheel_twin", kind), f"__name:={name}", *[f"_{argument}" for argument in arguments])


# One of each kind: sensor, rig, wheel, soil, and what grains have by themselves.
EFFECTS = ("ft_gain:gain_x=0.2", "steering_misalignment:angle=0.05", "wheel_eccentricity:amplitude=0.001,phase=0.5",
           "density_gradient:slope=2.0")
EMERGENT = "slip_sinkage:gain=0.5,length=0.1"


def one_process(bag, *arguments):
    """The values of the same run by the program `twin`."""
    subprocess.run([program("wheel_twin", "twin"), "run", "--fidelity", "dem", "--dem", SETTINGS, "--slip", "0.3", "--load",
                    "42.1", "--threads", "1", *arguments, "--out", bag], check=True, timeout=LIMIT)
    content = plain(read(bag))
    assert set(content) == set(TOPICS)
    return content


class Sides:
    """The three processes of a run, each with parameters of its own."""

    def __init__(self, tag, bag, *of_rig, patience="30.0"):
        shared = (f"patience:={patience}",)
        self.soil = side("dem_soil", f"soil_{tag}", "wheel:=amalia", f"dem:={SETTINGS}", "threads:=1", *shared)
        self.wheel = side("flexible_wheel", f"wheel_{tag}", "drive:=soil", *shared)
        self.rig = side("virtual_rig", f"rig_{tag}", "fidelity:=dem", f"dem:={SETTINGS}", f"bag:={bag}", "slip:=0.3",
                        "load:=42.1", "real_time_factor:=0", *of_rig, *shared)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in (self.rig, self.wheel, self.soil):
            process.__exit__()

    def lines(self, process, text):
        """Complaints of a process that has ended."""
        return [line for line in process.output().splitlines() if "ERROR" in line and text in line]


class Cosim(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        os.environ["WHEEL_TWIN_CACHE"] = CACHE
        cls.folder = tempfile.mkdtemp(dir=os.environ["ROS_HOME"])
        cls.reference = one_process(os.path.join(cls.folder, "one_process.bag"))

    def path(self, name):
        return os.path.join(self.folder, name)

    def assert_as_in_one_process(self, bag, reference=None):
        content = plain(read(bag))
        for topic in TOPICS:
            self.assertEqual(content[topic], (reference or self.reference)[topic], topic)

    def launched(self, nodelets, *arguments):
        """The bag of a run by the launch file."""
        bag = self.path(f"nodelets_{nodelets}_{len(arguments)}.bag")
        status = Collector("/rig/status", String)
        with launch("virtual_rig.launch", "fidelity:=dem", f"dem:={SETTINGS}", "threads:=1", "slip:=0.3", "load:=42.1",
                    "real_time_factor:=0", f"bag:={bag}", f"nodelets:={nodelets}", *arguments):
            status.wait_for_text("finished")
        status.close()
        return bag

    def test_the_same_numbers_as_in_one_process(self):
        for nodelets in ("true", "false"):
            self.assert_as_in_one_process(self.launched(nodelets))

    def test_every_effect_acts_where_it_belongs(self):
        for effect in EFFECTS:
            alone = one_process(self.path("effect.bag"), "--effect", effect)
            self.assertNotEqual(alone["/ft_sensor/wrench"], self.reference["/ft_sensor/wrench"], effect)
        reference = one_process(self.path("effects.bag"), *[word for effect in EFFECTS for word in ("--effect", effect)])
        for nodelets in ("true", "false"):
            self.assert_as_in_one_process(self.launched(nodelets, "effects:=" + " ".join(EFFECTS)), reference)

    def test_what_grains_do_by_themselves_is_refused_by_the_soil(self):
        status = Collector("/rig/status", String)
        with Sides("emergent", self.path("emergent.bag"), f"effects:={EFFECTS[0]} {EMERGENT}") as sides:
            status.wait_for_text("failed")
        status.close()
        for process in (sides.soil, sides.wheel, sides.rig):
            lines = sides.lines(process, "")
            self.assertEqual(len(lines), 1, lines)
            self.assertIn("effect slip_sinkage: fidelity dem: ", lines[0])
        self.assertIn("dem_soil: effect", sides.lines(sides.rig, "")[0])

    def cut_short(self, tag, end, patience="30.0"):
        """Lets `end` act on the sides while the run is under way; the bag and what the sides said."""
        bag = self.path(f"{tag}.bag")
        status = Collector("/rig/status", String)
        with Sides(tag, bag, "checkpoint_interval:=0.2", "hold_at_travel:=0.0003", patience=patience) as sides:
            status.wait_for_text("held")
            end(sides)
            self.assertTrue(call("/rig/start", Trigger).success)
            status.wait_for_text("failed")
            sides.soil.process.send_signal(signal.SIGCONT)  # a stopped process does not end
        status.close()
        self.assertTrue(os.path.exists(bag))  # closed: it has its name
        content = plain(read(bag))
        for topic in ("/ft_sensor/wrench", "/rig/joint_states"):
            self.assertGreater(len(content[topic]), 10)
            self.assertEqual(content[topic], self.reference[topic][:len(content[topic])])
        return sides, bag

    def test_a_soil_that_dies_and_a_run_that_goes_on(self):
        def kill(sides):
            sides.soil.end_with(signal.SIGKILL)
        sides, bag = self.cut_short("dead_soil", kill)
        self.assertEqual(len(sides.lines(sides.rig, "dem_soil is gone")), 1)
        self.assertEqual(len(sides.lines(sides.wheel, "dem_soil is gone")), 1)
        self.assertEqual(len(sides.lines(sides.rig, "")), 1)
        checkpoint = bag + ".checkpoint"
        self.assertTrue(os.path.exists(checkpoint))
        again = self.path("resumed.bag")
        status = Collector("/rig/status", String)
        with Sides("resumed", again, f"checkpoint:={checkpoint}", "resume:=true"):
            status.wait_for_text("finished")
        status.close()
        self.assert_as_in_one_process(again)
        self.assertFalse(os.path.exists(checkpoint))  # done with

    def test_a_wheel_that_dies(self):
        def kill(sides):
            sides.wheel.end_with(signal.SIGKILL)
        sides, _ = self.cut_short("dead_wheel", kill)
        self.assertEqual(len(sides.lines(sides.rig, "flexible_wheel is gone")), 1)
        self.assertEqual(len(sides.lines(sides.rig, "")), 1)

    def test_a_soil_that_stalls(self):
        def stop(sides):
            sides.soil.process.send_signal(signal.SIGSTOP)
        sides, _ = self.cut_short("stalled_soil", stop, patience="3.0")
        self.assertEqual(len(sides.lines(sides.rig, "dem_soil is silent for 3 s")), 1)
        self.assertEqual(len(sides.lines(sides.rig, "")), 1)

    def test_a_rig_that_dies(self):
        state = Collector("/soil/state", String)
        wheel = Collector("/wheel/status", String)
        with Sides("dead_rig", self.path("dead_rig.bag")) as sides:
            state.wait_for_text("running")
            sides.rig.end_with(signal.SIGKILL)
            wheel.wait_for_text("failed: virtual_rig is gone")
            state.wait(lambda messages: [m.data for m in messages].count("ready") >= 2, "the soil ready again")
        state.close()
        wheel.close()
        self.assertEqual(len(sides.lines(sides.soil, "virtual_rig is gone")), 1)

    def test_another_wheel_is_refused(self):
        status = Collector("/rig/status", String)
        with side("dem_soil", "soil_other", "wheel:=cmu_smooth", f"dem:={SETTINGS}"), \
                side("flexible_wheel", "wheel_other", "drive:=soil"), \
                side("virtual_rig", "rig_other", "fidelity:=dem", f"dem:={SETTINGS}") as rig:
            status.wait_for_text("failed")
        status.close()
        self.assertIn("the wheel has other faces", rig.output())


if __name__ == "__main__":
    rospy.init_node("cosim_test")
    rostest.rosrun("wheel_twin", "cosim", Cosim, sys.argv)
