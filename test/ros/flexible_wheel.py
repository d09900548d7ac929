#!/usr/bin/python3
"""The node flexible_wheel: the demonstration carries its load and deflects, and a wheel driven by commands answers step by
step with the numbers that physics asks for."""
import sys
import unittest

import rosgraph
import rospy
import rostest
from geometry_msgs.msg import Wrench, WrenchStamped
from ros_helpers import Collector, Process, launch, program, wait_for_subscribers
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray
from wheel_twin.msg import DisplacementStamped, WheelCommand, WheelState

STEP = 1.0e-5


def node(name, *arguments):
    """Private parameters stay with the master under the node's name: each test has its own."""
    return Process(program("wheel_twin", "flexible_wheel"), f"__name:={name}", *[f"_{argument}" for argument in arguments])


class FlexibleWheel(unittest.TestCase):
    def test_rolls_under_its_load(self):
        status = Collector("/wheel/status", String)
        deflection = Collector("/wheel/deflection", DisplacementStamped)
        reaction = Collector("/wheel/reaction", WrenchStamped)
        joints = Collector("/wheel/joint_states", JointState)
        markers = Collector("/wheel/markers", MarkerArray)
        transforms = Collector("/tf", TFMessage)
        with node("rolling", "wheel:=amalia", "load:=42.1", "travel:=0.0005", "publish_rate:=200", "real_time_factor:=0"):
            status.wait_for_text("held")
            self.assertEqual(status.messages[-1].data, "held")
            # CalculiX: 2.063 mm standing on a spring; the paper's models differ by 8.9 % at most.
            last = deflection.wait(lambda m: m and m[-1].displacement > 0.0015, "the deflection")[-1].displacement
            self.assertAlmostEqual(last, 2.063e-3, delta=0.089 * 2.063e-3)
            loads = [m.wrench.force.z for m in reaction.wait(lambda m: len(m) > 5, "reactions")[-5:]]
            self.assertAlmostEqual(sum(loads) / len(loads), 42.1, delta=2.0)
            state = joints.wait(lambda m: len(m) > 5, "joints")[-1]
            self.assertEqual(len(state.name), 1 + 64 + 32)
            springs = {n: (p, e) for n, p, e in zip(state.name, state.position, state.effort) if n.startswith("spring")}
            self.assertLess(springs["spring_08_0"][0], -1e-4)  # pressed, at the bottom
            self.assertAlmostEqual(springs["spring_08_0"][1], -2490.0 * springs["spring_08_0"][0], delta=1e-9)
            names = {m.ns: m for m in markers.wait(lambda m: len(m) > 2, "markers")[-1].markers}
            self.assertEqual(len(names["rim"].points), len(names["rim"].colors))
            self.assertEqual(len(names["rim"].points), (64 + 16) * 6 * 12)
            self.assertGreater(len({(c.r, c.g, c.b) for c in names["beams"].colors}), 5)
            frames = {(t.header.frame_id, t.child_frame_id) for m in transforms.messages for t in m.transforms}
            self.assertEqual(frames, {("rig", "hub"), ("hub", "wheel")})
        for collector in (status, deflection, reaction, joints, markers, transforms):
            collector.close()

    def test_as_a_nodelet_of_a_manager(self):
        status = Collector("/wheel/status", String)
        deflection = Collector("/wheel/deflection", DisplacementStamped)
        with launch("flexible_wheel.launch", "nodelet:=true", "wheel:=amalia", "travel:=0.0005", "publish_rate:=200",
                    "real_time_factor:=0"):
            status.wait_for_text("held")
            last = deflection.wait(lambda m: m and m[-1].displacement > 0.0015, "the deflection")[-1].displacement
            self.assertAlmostEqual(last, 2.063e-3, delta=0.089 * 2.063e-3)
            # A nodelet has no node of its own: its topics are the manager's.
            publishers = dict(rosgraph.Master(rospy.get_name()).getSystemState()[0])["/wheel/status"]
            self.assertEqual(publishers, ["/wheel_manager"])
        status.close()
        deflection.close()

    def test_lock_step(self):
        states = Collector("/wheel/state", WheelState)
        status = Collector("/wheel/status", String)
        commands = rospy.Publisher("/wheel/command", WheelCommand, queue_size=10)
        with node("driven", "wheel:=amalia", "drive:=commands", "hub_height:=0.5"):
            status.wait_for_text("waiting")
            first = states.wait(lambda m: m, "the first state")[0]
            self.assertEqual(first.step, 0)
            self.assertEqual(len(first.poses), 64)
            self.assertAlmostEqual(first.poses[0].position.z, 0.5 + 0.09, delta=2e-4)  # the top one
            wait_for_subscribers(rospy.get_name(), ["/wheel/command"])
            # A steady push on segment 48, which looks back: in the end the hub feels the same force; at once only a part.
            for step in range(40):
                command = WheelCommand(step=step, time_step=STEP)
                command.hub_position.z = 0.5
                command.segments = [Wrench() for _ in range(64)]
                command.segments[48].force.x = 2.0
                commands.publish(command)
                states.wait(lambda m, n=step + 1: m[-1].step == n, f"step {step + 1}")
            last = states.messages[-1]
            self.assertGreater(last.poses[48].position.x, first.poses[48].position.x + 1e-6)
            self.assertGreater(last.twists[48].linear.x, 0.0)
            commands.publish(WheelCommand(step=7, time_step=STEP))
            status.wait(lambda m: m[-1].data == "failed: command for step 7: the wheel is at step 40", "the refusal")
        states.close()
        status.close()

    def test_wrong_parameter_is_one_line(self):
        with node("refusing", "wheel:=amalia", "loadd:=42.1") as process:
            self.assertNotEqual(process.wait(), 0)
            self.assertIn("loadd", process.output())


if __name__ == "__main__":
    rospy.init_node("flexible_wheel_test")
    rostest.rosrun("wheel_twin", "flexible_wheel", FlexibleWheel, sys.argv)
