#!/usr/bin/python3
"""The node dem_soil by itself: prepares a small bed on request, shows it as cloud, height map and rut, says what it does,
saves it, and refuses what it cannot do in one line."""
import math
import os
import statistics
import struct
import sys
import tempfile
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from ros_helpers import Collector, Process, program
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String
from std_srvs.srv import Trigger
from visualization_msgs.msg import Marker

SMALL = ("length:=0.06", "width:=0.06", "depth:=0.03", "fill_friction:=0.9")


def node(name, *arguments):
    """Private parameters stay with the master under the node's name: each test has its own."""
    return Process(program("wheel_twin", "dem_soil"), f"__name:={name}", *[f"_{argument}" for argument in arguments])


def points(cloud):
    """Field name -> values."""
    names = [field.name for field in cloud.fields]
    assert all(field.datatype == field.FLOAT32 for field in cloud.fields)
    rows = [struct.unpack_from(f"<{len(names)}f", cloud.data, at) for at in range(0, len(cloud.data), cloud.point_step)]
    return dict(zip(names, zip(*rows)))


def ask(service):
    rospy.wait_for_service(service, 60)
    return rospy.ServiceProxy(service, Trigger)()


class DemSoil(unittest.TestCase):
    def test_prepares_shows_and_saves(self):
        path = os.path.join(tempfile.mkdtemp(), "bed.h5")
        state = Collector("/soil/state", String)
        cloud = Collector("/soil/cloud", PointCloud2)
        heights = Collector("/soil/height_map", PointCloud2)
        rut = Collector("/soil/rut", Marker)
        diagnostics = Collector("/diagnostics", DiagnosticArray)
        with node("small_bed", *SMALL, "prepare_at_start:=false", "publish_rate:=2", f"save_path:={path}"):
            state.wait_for_text("empty")
            refused = ask("/soil/save")
            self.assertFalse(refused.success)
            self.assertIn("no bed", refused.message)
            self.assertTrue(ask("/soil/prepare").success)
            state.wait(lambda m: m[-1].data != "preparing" and m[-1].data != "empty", "the end of preparing", 250)
            self.assertEqual([m.data for m in state.messages], ["empty", "preparing", "ready"])

            clouds = cloud.wait(lambda m: len(m) > 3, "clouds")
            stamps = [m.header.stamp.to_sec() for m in clouds]
            # A late one shortens the next gap; over several the rate is 2 Hz at most.
            self.assertGreater(stamps[-1] - stamps[0], 0.45 * (len(stamps) - 1))
            spheres = points(clouds[-1])
            self.assertEqual(list(spheres), ["x", "y", "z", "radius", "speed", "force"])
            self.assertEqual(clouds[-1].header.frame_id, "rig")
            self.assertGreater(len(spheres["x"]), 400)
            self.assertGreater(min(z - r for z, r in zip(spheres["z"], spheres["radius"])), -0.0301)
            self.assertLess(max(spheres["speed"]), 0.02)
            # What a clump's contacts exert on it carries its weight: more than one of its spheres, less than all four.
            ball = statistics.median(2759.0 * 9.81 * 4.0 / 3.0 * math.pi * r**3 for r in spheres["radius"])
            self.assertGreater(statistics.median(spheres["force"]), ball)
            self.assertLess(statistics.median(spheres["force"]), 4.0 * ball)

            surface = heights.wait(lambda m: m, "the height map")[-1]
            self.assertEqual(len(surface.data), surface.row_step * surface.height)
            self.assertGreaterEqual(surface.width, 20)
            self.assertGreaterEqual(surface.height, 20)
            level = [z for z in points(surface)["z"] if not math.isnan(z)]
            self.assertAlmostEqual(statistics.mean(level), 0.0, delta=0.0015)
            line = rut.wait(lambda m: m, "the rut")[-1]
            self.assertEqual(line.type, Marker.LINE_STRIP)
            self.assertGreaterEqual(len(line.points), 20)
            self.assertAlmostEqual(statistics.mean(p.z for p in line.points), 0.0, delta=0.002)

            saved = ask("/soil/save")
            self.assertTrue(saved.success, saved.message)
            self.assertEqual(saved.message, path)
            self.assertGreater(os.path.getsize(path), 10000)
            # A second time the bed comes from the cache: the same spheres.
            self.assertTrue(ask("/soil/prepare").success)
            state.wait_for_text("ready", 2)
            count = len(cloud.messages)
            again = points(cloud.wait(lambda m: len(m) > count + 1, "a cloud of the fetched bed")[-1])
            self.assertEqual(again["x"], spheres["x"])
            entries = diagnostics.wait(lambda m: any(s.values for a in m for s in a.status), "diagnostics")[-1].status
            self.assertEqual(entries[0].level, DiagnosticStatus.OK)
            self.assertIn("packing density", {v.key for v in entries[0].values})
        for collector in (state, cloud, heights, rut, diagnostics):
            collector.close()

    def test_a_bed_that_cannot_be_made_is_said(self):
        state = Collector("/soil/state", String)
        with node("impossible", "length:=10", "width:=10", "depth:=2", "fill_friction:=0.9"):
            failed = state.wait(lambda m: m and m[-1].data.startswith("failed"), "the failure")[-1].data
            self.assertIn("bed of 10 x 10 x 2 m", failed)
            self.assertIn("GB of memory", failed)
            self.assertNotIn("\n", failed)
        state.close()

    def test_wrong_parameters_are_one_line(self):
        for name, argument, said in (("fast", "publish_rate:=5", "publish_rate"), ("unknown", "soil:=nowhere", "nowhere"),
                                     ("mistyped", "lenght:=0.1", "lenght"), ("nan", "depth:=nan", "depth")):
            with node(name, argument) as process:
                self.assertNotEqual(process.wait(), 0, argument)
                lines = [text for text in process.output().splitlines() if said in text]
                self.assertEqual(len(lines), 1, process.output())


if __name__ == "__main__":
    os.environ["WHEEL_TWIN_CACHE"] = os.path.join(os.environ["ROS_HOME"], "beds")
    rospy.init_node("dem_soil_test")
    rostest.rosrun("wheel_twin", "dem_soil", DemSoil, sys.argv)
