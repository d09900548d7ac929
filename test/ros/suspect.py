#!/usr/bin/python3
"""live_twin against a rig whose draw wire skips: it warns while the rig still runs and names the likeliest effect; with a twin
file that has the effect the residual stays within its band."""
import os
import sys
import tempfile
import unittest

import rosbag
import roslib.packages
import rospy
import rostest
import yaml
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from ros_helpers import Collector, launch, read, rig
from std_msgs.msg import String

LOAD, SKIP = 42.1, 0.008  # N, m


def config(kind, name, keys):
    """The keys that a twin file has of a wheel or soil of the configuration folder."""
    folder = os.path.join(roslib.packages.get_pkg_dir("wheel_twin"), "config", kind)
    with open(os.path.join(folder, name + ".yaml")) as file:
        values = yaml.safe_load(file)
    return {key: values[key] for key in keys}


def twin_file(step, time):
    wheel = config("wheels", "amalia", ("name", "radius", "width", "grousers", "grouser_height", "stiffness"))
    soil = config("soils", "mars_simulant", ("name", "k_c", "k_phi", "n", "c", "phi", "K", "c1", "c2", "gamma", "weight_density"))
    mount = config("rigs", "polito", ("mount",))["mount"]
    return {"schema": 1, "name": "revised", "wheel": wheel, "soil": soil,
            "rig": {"arm_z": mount["arm_z"], "drive_torque_share": mount["drive_torque_share"], "drive_loss": 0.0,
                    "start_up": 1.0},
            "effects": [{"name": "draw_wire_jump", "parameters": {"step": step, "time": time}}]}


def reports(arrays):
    return [s for a in arrays for s in a.status if "live twin" in s.name]


class Suspect(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        """A run whose hub displacement reads SKIP more from its middle on."""
        folder = tempfile.mkdtemp(dir=os.environ["ROS_HOME"])
        plain = os.path.join(folder, "plain.bag")
        cls.bag, cls.twin = os.path.join(folder, "run.bag"), os.path.join(folder, "revised_twin.yaml")
        status = Collector("/rig/status", String)
        with rig(plain, "slip:=0.3", f"load:={LOAD}", "travel:=0.3", "publish_rate:=50", "real_time_factor:=0"):
            status.wait_for_text("finished")
        status.close()
        rospy.delete_param("/virtual_rig")
        stamps = [v[0] + 1e-9 * v[1] for v in read(plain)["/rig/joint_states"]]
        cls.time = 0.5 * (stamps[-1] - stamps[0])
        with rosbag.Bag(plain) as source, rosbag.Bag(cls.bag, "w") as target:
            for topic, message, stamp in source.read_messages():
                if topic.endswith("displacement") and message.header.stamp.to_sec() > stamps[0] + cls.time:
                    message.displacement += SKIP
                target.write(topic, message, stamp)
        with open(cls.twin, "w") as file:
            yaml.safe_dump(twin_file(SKIP, cls.time), file)

    def test_the_likeliest_effect_is_named_while_the_rig_runs(self):
        diagnostics = Collector("/diagnostics", DiagnosticArray)
        with launch("replay.launch", f"bag:={self.bag}", "rate:=2", f"load:={LOAD}"):
            diagnostics.wait(lambda m: any("hub displacement is not what the twin predicts" in s.message for s in reports(m)),
                             "the warning")
            found = diagnostics.wait(lambda m: any("likeliest effect: draw_wire_jump" in s.message for s in reports(m)),
                                     "the likeliest effect")
        named = [s for s in reports(found) if "likeliest effect" in s.message][-1]
        self.assertEqual(named.level, DiagnosticStatus.WARN)
        diagnostics.close()

    def test_a_twin_with_the_effect_keeps_the_band(self):
        diagnostics = Collector("/diagnostics", DiagnosticArray)
        with launch("replay.launch", f"bag:={self.bag}", "rate:=2", f"load:={LOAD}", f"twin:={self.twin}") as process:
            process.wait()
        told = reports(diagnostics.messages)
        self.assertTrue(any("following" in s.message for s in told))
        self.assertFalse([s.message for s in told if "not what the twin predicts" in s.message])
        diagnostics.close()


if __name__ == "__main__":
    rospy.init_node("suspect")
    rostest.rosrun("wheel_twin", "suspect", Suspect, sys.argv)
