#!/usr/bin/python3
"""A bag recorded by rosbag record from the live rig holds the same messages as the bag that the rig writes itself.

The first run, as fast as it goes, says how many messages each topic gets (the same seed gives the same run). In the second,
at half of real time and 100 Hz, one recorder a topic is told that number: it ends by itself when it has them all, so nothing has to be
guessed about messages under way. A message lost is a recorder that does not end. rosbag record keeps 100 messages a topic
that it has not got round to: 2 s here, which a busy machine needs; at 1 kHz and twice real time it would be 50 ms."""
import os
import sys
import tempfile
import unittest

import rospy
import rostest
from ros_helpers import TOPICS, Collector, Process, call, program, read, rig, wait_for_subscribers
from std_msgs.msg import String
from std_srvs.srv import Trigger

RUN = ("slip:=0.3", "load:=42.1", "travel:=0.05", "seed:=7", "publish_rate:=100")


class RecordAgrees(unittest.TestCase):
    def test_recorded_and_written_bag_hold_the_same(self):
        folder = tempfile.mkdtemp(dir=os.environ["ROS_HOME"])
        first, second = os.path.join(folder, "first.bag"), os.path.join(folder, "second.bag")
        status = Collector("/rig/status", String)
        with rig(first, *RUN, "real_time_factor:=0"):
            status.wait_for_text("finished")
        status.close()
        counts = {topic: len(messages) for topic, messages in read(first).items()}
        self.assertEqual(set(counts), set(TOPICS))

        recorded = {topic: os.path.join(folder, topic.strip("/").replace("/", "_") + ".bag") for topic in TOPICS}
        with rig(second, *RUN, "real_time_factor:=0.5", "autostart:=false"):
            recorders = [Process(program("rosbag", "record"), "--limit", str(counts[topic]), "--tcpnodelay", "-O",
                                 recorded[topic], topic, f"__name:=recorder_{i}") for i, topic in enumerate(TOPICS)]
            wait_for_subscribers("/virtual_rig", TOPICS)
            status = Collector("/rig/status", String)
            self.assertTrue(call("/rig/start", Trigger).success)
            status.wait_for_text("finished")
            for recorder in recorders:
                with recorder:
                    recorder.wait()

        written = read(second)
        self.assertEqual({topic: len(messages) for topic, messages in written.items()}, counts)
        for topic in TOPICS:
            self.assertEqual(read(recorded[topic])[topic], written[topic], topic)


if __name__ == "__main__":
    rospy.init_node("record_agrees")
    rostest.rosrun("wheel_twin", "record_agrees", RecordAgrees, sys.argv)
