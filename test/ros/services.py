#!/usr/bin/python3
"""Services of the live rig, and that it leaves a whole, readable bag however it is ended."""
import os
import signal
import sys
import tempfile
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from ros_helpers import TOPICS, Collector, Process, call, program, read, rig
from std_msgs.msg import String
from std_srvs.srv import Trigger

LONG = ("slip:=0.3", "load:=42.1", "travel:=0.7")


def mean_of_z(messages):
    return sum(m.wrench.force.z for m in messages) / len(messages)


class Services(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(dir=os.environ["ROS_HOME"])
        self.bag = os.path.join(self.folder, "run.bag")

    def whole(self, bag):
        """The bag has its name, nothing else lies about, and every topic of a rig log is in it."""
        self.assertTrue(os.path.exists(bag), os.listdir(self.folder))
        self.assertFalse([name for name in os.listdir(self.folder) if name.endswith(".active")])
        content = read(bag)
        self.assertEqual(set(content), set(TOPICS))
        return content

    def test_start_stop_and_bias(self):
        status = Collector("/rig/status", String)
        wrench = Collector("/ft_sensor/wrench", WrenchStamped)
        diagnostics = Collector("/diagnostics", DiagnosticArray)
        with rig(self.bag, *LONG, "autostart:=false", "real_time_factor:=2"):
            status.wait_for_text("idle")
            self.assertFalse(call("/rig/stop", Trigger).success)        # nothing to stop
            self.assertFalse(call("/ft_sensor/bias", Trigger).success)  # nothing to tare
            self.assertTrue(call("/rig/start", Trigger).success)
            status.wait_for_text("running")
            self.assertFalse(call("/rig/start", Trigger).success)       # one run at a time
            wrench.wait(lambda m: len(m) > 100 and mean_of_z(m[-100:]) > 42.0, "the load on the soil")
            self.assertTrue(call("/ft_sensor/bias", Trigger).success)
            # The load was between 42.0 and 42.1 N, less a resolution of 1/16 N: what follows reads zero within that.
            before = len(wrench.messages)
            tared = wrench.wait(lambda m: len(m) >= before + 600, "readings after the tare")
            self.assertLess(abs(mean_of_z(tared[-100:])), 0.2)
            self.assertTrue(call("/rig/stop", Trigger).success)
            status.wait_for_text("finished")
            diagnostics.wait(lambda m: any("virtual rig" in s.name and s.level == 0 for a in m for s in a.status),
                             "the state of the rig")
            first = self.whole(self.bag)
            loads = [value[5] for value in first["/ft_sensor/wrench"]]
            self.assertGreater(max(loads), 41.0)
            self.assertLess(abs(loads[-1]), 2.0)  # the tare is in the bag as well
            # A second run has a bag of its own.
            self.assertTrue(call("/rig/start", Trigger).success)
            status.wait_for_text("running", times=2)
            self.assertTrue(call("/rig/stop", Trigger).success)
            status.wait_for_text("finished", times=2)
            self.whole(os.path.join(self.folder, "run_2.bag"))

    def ended_by(self, number, *command):
        wrench = Collector("/ft_sensor/wrench", WrenchStamped)
        with Process(*command) as process:
            seen = wrench.wait(lambda m: len(m) > 1000, "the first second of the run")
            self.assertEqual(process.end_with(number), 0, process.output())
        wrench.close()
        content = self.whole(self.bag)
        # What was on the topic is in the bag.
        self.assertGreaterEqual(len(content["/ft_sensor/wrench"]), len(seen))

    def rig_command(self):
        return (program("wheel_twin", "virtual_rig"), f"_bag:={self.bag}", "_travel:=0.7")

    def test_sigint_leaves_a_readable_bag(self):
        self.ended_by(signal.SIGINT, *self.rig_command())

    def test_sigterm_leaves_a_readable_bag(self):
        self.ended_by(signal.SIGTERM, *self.rig_command())

    def nodelet_ended_by(self, number):
        rospy.set_param("/rig_nodelet", {"bag": self.bag, "travel": 0.7})
        nodelet = program("nodelet", "nodelet")
        wrench = Collector("/ft_sensor/wrench", WrenchStamped)
        with Process(nodelet, "manager", "__name:=manager") as manager, \
                Process(nodelet, "load", "wheel_twin/virtual_rig", "manager", "--no-bond", "__name:=rig_nodelet"):
            wrench.wait(lambda m: len(m) > 1000, "the first second of the run")
            self.assertEqual(manager.end_with(number), 0, manager.output())
        wrench.close()
        self.whole(self.bag)

    def test_sigint_to_the_nodelet_manager_leaves_a_readable_bag(self):
        self.nodelet_ended_by(signal.SIGINT)

    def test_sigterm_to_the_nodelet_manager_leaves_a_readable_bag(self):
        self.nodelet_ended_by(signal.SIGTERM)

    def test_a_wrong_parameter_is_one_clear_line(self):
        for argument, said in (("slip:=2.0", "/virtual_rig/slip: 2 is outside -1 to 1"),
                               ("load:=heavy", "/virtual_rig/load: 'heavy' is not a number"),
                               ("slop:=0.3", "/virtual_rig/slop: is not known")):
            rospy.delete_param("/virtual_rig") if rospy.has_param("/virtual_rig") else None
            with rig(self.bag, argument) as process:
                self.assertEqual(process.wait(), 1)
            self.assertIn(said, process.output())
        rospy.delete_param("/virtual_rig")
        self.assertEqual(os.listdir(self.folder), [])

    def tearDown(self):
        for name in ("/virtual_rig", "/rig_nodelet"):
            if rospy.has_param(name):
                rospy.delete_param(name)


if __name__ == "__main__":
    rospy.init_node("services")
    rostest.rosrun("wheel_twin", "services", Services, sys.argv)
