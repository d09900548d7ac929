#!/usr/bin/python3
"""Rig and live twin as nodelets of one manager and as processes of their own: the same topics and services, and the same
numbers in the bag of the rig."""
import os
import sys
import tempfile
import unittest

import rosgraph
import rospy
import rostest
from geometry_msgs.msg import WrenchStamped
from ros_helpers import TOPICS, Collector, launch, read
from std_msgs.msg import String

NODES = ("/virtual_rig", "/live_twin", "/rig_manager")
OWN = ("/ft_sensor/", "/draw_wire/", "/rig/", "/twin/", "/soil/", "/diagnostics")


def interface():
    """Topics with their types, and services, of the nodes under test."""
    master = rosgraph.Master(rospy.get_name())
    published, subscribed, services = master.getSystemState()
    kinds = dict(master.getTopicTypes())

    def of_nodes(entries):
        return {(name, kinds.get(name)) for name, nodes in entries if name.startswith(OWN) and set(nodes) & set(NODES)}
    return of_nodes(published), of_nodes(subscribed), {n for n, nodes in services if n.startswith(OWN) and set(nodes) & set(NODES)}


class Nodelets(unittest.TestCase):
    def run_as(self, nodelets, folder):
        bag = os.path.join(folder, f"nodelets_{nodelets}.bag")
        status = Collector("/rig/status", String)
        twin = Collector("/twin/wrench", WrenchStamped)
        with launch("virtual_rig.launch", f"nodelets:={nodelets}", f"bag:={bag}", "twin:=true", "travel:=0.05",
                    "real_time_factor:=4"):
            status.wait_for_text("running")
            twin.wait(lambda m: len(m) > 50, "the twin's prediction")
            seen = interface()
            status.wait_for_text("finished")
        status.close()
        twin.close()
        content = read(bag)
        start = min((v[0], v[1]) for values in content.values() for v in values)
        return seen, {topic: [v[2:] for v in values] for topic, values in content.items()}, start

    def test_the_same_topics_and_the_same_numbers(self):
        folder = tempfile.mkdtemp(dir=os.environ["ROS_HOME"])
        one, one_log, one_start = self.run_as("true", folder)
        two, two_log, two_start = self.run_as("false", folder)
        self.assertEqual(one, two)
        for part, name in ((one[0], "/ft_sensor/wrench"), (one[0], "/twin/residual/wrench"), (one[1], "/rig/joint_states")):
            self.assertIn(name, {entry[0] for entry in part})
        self.assertEqual(one[2], {"/rig/start", "/rig/stop", "/ft_sensor/bias"})
        self.assertNotEqual(one_start, two_start)  # two runs
        self.assertEqual(set(one_log), set(TOPICS))
        for topic in TOPICS:
            self.assertEqual(one_log[topic], two_log[topic], topic)


if __name__ == "__main__":
    rospy.init_node("nodelets")
    rostest.rosrun("wheel_twin", "nodelets", Nodelets, sys.argv)
