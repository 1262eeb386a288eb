"""Reads every message of a bag that visloc wrote with two independent readers, and checks what is in it.

    python check_bag.py BAG.mcap [--results] [--frames N]
"""

import argparse
import math
import sys
from collections import Counter
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

RESULTS = {
    "/visloc/pose": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "/visloc/path": "nav_msgs/msg/Path",
    "/visloc/hypotheses": "geometry_msgs/msg/PoseArray",
    "/visloc/reliability": "std_msgs/msg/Float64",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}


def fail(reason):
    sys.exit("check_bag: " + reason)


def norm(q):
    return math.sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w)


def check(topic, kind, message):
    """What any receiver relies on."""
    if kind == "sensor_msgs/msg/CompressedImage" and bytes(message.data[:2]) not in (b"\xff\xd8", b"\x89P"):
        fail(f"{topic}: neither JPEG nor PNG")
    if kind == "sensor_msgs/msg/CameraInfo" and not (message.width > 0 and message.k[0] > 0):
        fail(f"{topic}: no camera")
    if kind == "tf2_msgs/msg/TFMessage":
        for transform in message.transforms:
            if abs(norm(transform.transform.rotation) - 1) > 1e-6:
                fail(f"{topic}: rotation of {transform.child_frame_id} is none")
    if kind == "geometry_msgs/msg/PoseWithCovarianceStamped":
        if message.header.frame_id != "map" or abs(norm(message.pose.pose.orientation) - 1) > 1e-6:
            fail(f"{topic}: expected a pose in the map")
        if any(message.pose.covariance[i * 7] <= 0 for i in range(6)):
            fail(f"{topic}: expected positive variances")
    if kind == "std_msgs/msg/Float64" and not 0 <= message.data <= 1:
        fail(f"{topic}: expected a reliability, found {message.data}")
    if kind == "diagnostic_msgs/msg/DiagnosticArray" and message.status[0].message not in ("localized", "not localized"):
        fail(f"{topic}: {message.status[0].message}")


def with_mcap(path):
    counts = Counter()
    with open(path, "rb") as file:
        for schema, channel, _, message in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            check(channel.topic, schema.name, message)
            counts[channel.topic, schema.name] += 1
    return counts


def with_rosbags(path):
    counts = Counter()
    with AnyReader([Path(path)], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        for connection, _, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            check(connection.topic, connection.msgtype, message)
            counts[connection.topic, connection.msgtype] += 1
    return counts


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bag")
    parser.add_argument("--results", action="store_true", help="expect results beside the input")
    parser.add_argument("--frames", type=int, help="expect so many images")
    args = parser.parse_args()
    counts, others = with_mcap(args.bag), with_rosbags(args.bag)
    if counts != others:
        fail(f"the readers disagree: {counts} and {others}")
    types = {topic: kind for topic, kind in counts}
    if args.results and any(types.get(topic) != kind for topic, kind in RESULTS.items()):
        fail(f"expected {RESULTS}, found {types}")
    images = sum(n for (_, kind), n in counts.items() if kind.endswith("Image"))
    if args.frames is not None and images != args.frames:
        fail(f"expected {args.frames} images, found {images}")
    for (topic, kind), number in sorted(counts.items()):
        print(f"{topic:28} {kind:48} {number}")
    print(f"{sum(counts.values())} messages, read by mcap-ros2-support and by rosbags")


if __name__ == "__main__":
    main()
