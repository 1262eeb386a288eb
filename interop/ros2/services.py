"""Calls the services of visloc through Cyclone DDS, and looks at what it publishes for those who come later.

    python services.py localize|slam [--domain N] [--rmw fast|cyclone]

`localize` expects a run on a known map with --publish-map, `slam` one of SLAM with --save. Fails unless every answer is as it should be.
"""

import argparse
import sys
import time

from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

import messages as ros

RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10))
KEPT = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(1), Policy.Durability.TransientLocal)
SECONDS = 20.0


class Service:
    """A client of one service."""

    def __init__(self, participant, name, kind, is_cyclone):
        package, kind, fields = kind
        self.name, self.is_cyclone, self.number = name, is_cyclone, 0
        self.request, answer = ros.service(package, kind, is_cyclone, fields)
        self.writer = DataWriter(participant, Topic(participant, f"rq{name}Request", self.request), qos=RELIABLE)
        self.reader = DataReader(participant, Topic(participant, f"rr{name}Reply", answer), qos=RELIABLE)

    def call(self, *content):
        until = time.time() + SECONDS
        while not self.writer.get_matched_subscriptions() or not self.reader.get_matched_publications():
            if time.time() > until:
                sys.exit(f"{self.name}: nobody serves it")
            time.sleep(0.05)
        self.number += 1
        client = 0x0123456789ABCDEF
        self.writer.write(self.request(*([client, self.number] if self.is_cyclone else []), *content))
        while time.time() < until:
            for answer in self.reader.take(N=10):
                if type(answer).__name__ == "InvalidSample":
                    continue
                if self.is_cyclone:
                    assert (answer.client, answer.number) == (client, self.number), answer
                print(f"{self.name}: {'done' if answer.success else 'refused'}: {answer.message}")
                return answer.success, answer.message
            time.sleep(0.01)
        sys.exit(f"{self.name}: no answer")


TRIGGER = ("std_srvs", "Trigger", {"structure_needs_at_least_one_member": ros.uint8})
SET_POSE = ("visloc_msgs", "SetPose", {"pose": ros.PoseWithCovarianceStamped})
MAP_FILE = ("visloc_msgs", "MapFile", {"name": str})
SET_SCALE = ("visloc_msgs", "SetScale", {"meters_per_unit": ros.float64})


def latest(participant, topic, kind):
    """What is published on a topic; who comes late gets the last one."""
    reader = DataReader(participant, Topic(participant, "rt" + topic, kind), qos=KEPT)
    until = time.time() + SECONDS
    while time.time() < until:
        came = [m for m in reader.take(N=10) if type(m).__name__ != "InvalidSample"]
        if came:
            return came[-1]
        time.sleep(0.05)
    sys.exit(f"{topic}: nothing came")


def expect(outcome, success, words):
    assert outcome[0] == success and words in outcome[1], (outcome, success, words)


def on_a_known_map(participant, serve):
    state = latest(participant, "/visloc/state", ros.NodeState)
    assert (state.id, state.label) in [(2, "inactive"), (3, "active")], state
    grid = latest(participant, "/map", ros.OccupancyGrid)
    counts = {value: list(grid.data).count(value) for value in (-1, 0, 100)}
    assert grid.header.frame_id == "map" and grid.info.width * grid.info.height == len(grid.data) == sum(counts.values())
    assert counts[0] > counts[-1] > counts[100] > 0, counts
    print(f"/map: {grid.info.width} x {grid.info.height} cells of {grid.info.resolution:.2f} m: {counts}")
    set_pose = serve("/visloc/set_pose", SET_POSE)
    covariance = [0.25 if i in (0, 7) else 0.1 if i == 35 else 0.0 for i in range(36)]
    at = lambda x: ros.PoseWithCovarianceStamped(
        ros.Header(ros.Time(0, 0), "map"),
        ros.PoseWithCovariance(ros.Pose(ros.Vector3(x, 1.1, 0.0), ros.Quaternion(0.0, 0.0, 0.0, 1.0)), covariance),
    )
    expect(set_pose.call(at(-1.4)), True, "initial pose: -1.40, 1.10 m")
    expect(set_pose.call(at(float("nan"))), False, "expected numbers")
    expect(serve("/visloc/reset", TRIGGER).call(0), True, "the pose is forgotten")
    expect(serve("/visloc/save_map", MAP_FILE).call(""), False, "no map of its own")
    expect(serve("/visloc/load_map", MAP_FILE).call("hall"), False, "start again")
    expect(serve("/visloc/set_scale", SET_SCALE).call(2.0), False, "in meters already")
    state = latest(participant, "/visloc/state", ros.NodeState)
    assert (state.id, state.label) == (3, "active"), state


def without_a_map(participant, serve):
    points = DataReader(participant, Topic(participant, "rt/visloc/points", ros.PointCloud2), qos=RELIABLE)
    poses = DataReader(participant, Topic(participant, "rt/visloc/camera_pose", ros.PoseStamped), qos=RELIABLE)
    until, num_points = time.time() + 3 * SECONDS, 0
    while num_points < 50 and time.time() < until:
        num_points = max([num_points] + [cloud.width for cloud in points.take(N=10) if isinstance(cloud, ros.PointCloud2)])
        time.sleep(0.1)
    assert num_points >= 50, f"{num_points} landmarks"
    save, load = serve("/visloc/save_map", MAP_FILE), serve("/visloc/load_map", MAP_FILE)
    scale = serve("/visloc/set_scale", SET_SCALE)
    expect(scale.call(-1.0), False, "more than 0")
    expect(save.call("units"), True, "units.vmap")
    expect(scale.call(2.5), True, "a map unit is 2.5 m")
    expect(save.call("told"), True, "told.vmap")
    expect(save.call(""), True, "map saved")
    expect(save.call("../told"), False, "without folders")
    expect(load.call("nothing"), False, "nothing.vmap")
    expect(load.call("told"), True, "the camera is looked for in it")
    poses.take(N=1000)
    until, num_poses = time.time() + SECONDS, 0
    while num_poses < 3 and time.time() < until:
        num_poses += sum(isinstance(pose, ros.PoseStamped) for pose in poses.take(N=100))
        time.sleep(0.1)
    assert num_poses >= 3, "not found in the map that was loaded"
    expect(scale.call(2.5), False, "in meters already (told by somebody)")
    pose = ros.PoseWithCovarianceStamped(
        ros.Header(ros.Time(0, 0), "map"),
        ros.PoseWithCovariance(ros.Pose(ros.Vector3(0.0, 0.0, 0.0), ros.Quaternion(0.0, 0.0, 0.0, 1.0)), [0.0] * 36),
    )
    expect(serve("/visloc/set_pose", SET_POSE).call(pose), False, "no map to place a pose on")
    expect(serve("/visloc/reset", TRIGGER).call(0), True, "the map is forgotten")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["localize", "slam"])
    parser.add_argument("--domain", type=int, default=0)
    parser.add_argument("--rmw", choices=["fast", "cyclone"], default="fast")
    args = parser.parse_args()
    participant = DomainParticipant(args.domain)
    serve = lambda name, kind: Service(participant, name, kind, args.rmw == "cyclone")
    (on_a_known_map if args.what == "localize" else without_a_map)(participant, serve)


if __name__ == "__main__":
    main()
