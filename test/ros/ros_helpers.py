"""What the ROS tests share: messages collected from topics, processes that end, bags as plain values. Waiting is for
something to happen, with a limit; nothing sleeps in the hope that it has."""
import signal
import subprocess
import threading
import time
import xmlrpc.client

import rosbag
import rosgraph
import roslib.packages
import rospy

TOPICS = ("/ft_sensor/wrench", "/draw_wire/displacement", "/rig/joint_states", "/rig/temperature")
LIMIT = 90.0  # s that anything here may take on a busy machine


class Collector:
    """Keeps the messages of a topic."""

    def __init__(self, topic, kind):
        self.changed = threading.Condition()
        self.messages = []
        self.topic = topic
        self.subscriber = rospy.Subscriber(topic, kind, self._add, queue_size=100000, tcp_nodelay=True)

    def _add(self, message):
        with self.changed:
            self.messages.append(message)
            self.changed.notify_all()

    def wait(self, predicate, what, limit=LIMIT):
        """Waits until predicate(messages) holds; returns the messages."""
        with self.changed:
            if not self.changed.wait_for(lambda: predicate(self.messages), limit):
                raise AssertionError(f"{self.topic}: {what} did not come in {limit} s ({len(self.messages)} messages)")
            return list(self.messages)

    def wait_for_text(self, text, times=1):
        return self.wait(lambda messages: sum(m.data == text for m in messages) >= times, f"'{text}'")

    def close(self):
        self.subscriber.unregister()


def program(package, name):
    found = roslib.packages.find_node(package, name)
    assert found, f"{package}/{name} is not built"
    return found[0]


class Process:
    """A process of the test, ended with it."""

    def __init__(self, *command):
        self.command = command
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.lines = []
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stdout:
            self.lines.append(line)

    def output(self):
        self.reader.join(10)
        return "".join(self.lines)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            try:
                self.process.wait(30)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()

    def end_with(self, number, limit=LIMIT):
        self.process.send_signal(number)
        return self.wait(limit)

    def wait(self, limit=LIMIT):
        try:
            return self.process.wait(limit)
        except subprocess.TimeoutExpired:
            raise AssertionError(" ".join(self.command) + " did not end:\n" + "".join(self.lines[-40:])) from None


def rig(bag, *arguments, name="virtual_rig"):
    """The stand-alone virtual rig with private parameters `key:=value`."""
    parameters = [f"_{argument}" for argument in arguments]
    return Process(program("wheel_twin", "virtual_rig"), f"__name:={name}", f"_bag:={bag}", *parameters)


def launch(file, *arguments):
    return Process("roslaunch", "wheel_twin", file, *arguments)


def call(service, kind, limit=LIMIT):
    rospy.wait_for_service(service, limit)
    return rospy.ServiceProxy(service, kind)()


def wait_for_subscribers(node, topics, limit=LIMIT):
    """Until `node` itself says that it has a connection to a subscriber of each topic."""
    master = rosgraph.Master(rospy.get_name())
    deadline = time.monotonic() + limit
    reached = set()
    while time.monotonic() < deadline:
        try:
            bus = xmlrpc.client.ServerProxy(master.lookupNode(node)).getBusInfo(rospy.get_name())[2]
        except (rosgraph.MasterException, OSError):
            continue
        reached = {entry[4] for entry in bus if entry[2] == "o" and entry[5]}
        if all(topic in reached for topic in topics):
            return
    raise AssertionError(f"{node} has no subscriber on {sorted(set(topics) - reached)}")


def values(topic, message):
    """What a message says, as a tuple; stamp first."""
    stamp = (message.header.stamp.secs, message.header.stamp.nsecs)
    if topic.endswith("wrench"):
        w = message.wrench
        return (*stamp, message.header.frame_id, w.force.x, w.force.y, w.force.z, w.torque.x, w.torque.y, w.torque.z)
    if topic.endswith("displacement"):
        return (*stamp, message.header.frame_id, message.displacement)
    if topic.endswith("joint_states"):
        return (*stamp, tuple(message.name), tuple(message.position), tuple(message.velocity), tuple(message.effort))
    return (*stamp, message.temperature)


def read(path):
    """Topic -> list of values, in the order of the bag."""
    content = {}
    with rosbag.Bag(path) as bag:
        for topic, message, _ in bag.read_messages():
            content.setdefault(topic, []).append(values(topic, message))
    return content
