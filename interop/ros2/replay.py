"""Replays a ROS 2 bag as live topics through Cyclone DDS, and receives what visloc says about it.

    python replay.py BAG [--received FILE.csv] [--json FILE] [--drop N] [--late N] [--wrong-type] [--again] [--orders]
    python replay.py BAG --minutes M        over and over for so long, stamped as if it happened now

It waits until somebody subscribes to the images, plays the bag in real time (or --rate times as fast), and waits a moment for
the last answers. Every message of results is decoded by Cyclone DDS and counted; poses go to the CSV file.
"""

import argparse
import csv
import gc
import json
import math
import sys
import threading
import time

from cyclonedds.core import Listener, Policy, Qos, WaitSet, ReadCondition, ViewState, InstanceState, SampleState
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

import messages as ros

SENSOR = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(10))
RELIABLE = Qos(Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.History.KeepLast(100))
LATCHED = Qos(
    Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.History.KeepLast(1), Policy.Durability.TransientLocal
)

RESULTS = {
    "/visloc/pose": (ros.PoseWithCovarianceStamped, RELIABLE),
    "/visloc/path": (ros.Path, RELIABLE),
    "/visloc/hypotheses": (ros.PoseArray, RELIABLE),
    "/visloc/reliability": (ros.Float64, RELIABLE),
    "/visloc/camera_pose": (ros.PoseStamped, RELIABLE),
    "/visloc/points": (ros.PointCloud2, LATCHED),
    "/diagnostics": (ros.DiagnosticArray, RELIABLE),
    "/tf": (ros.TFMessage, RELIABLE),
}


def stamp(header):
    return header.stamp.sec * 1_000_000_000 + header.stamp.nanosec


class Results:
    """Receives all topics of results in a thread of its own."""

    def __init__(self, participant):
        self.counts = {topic: 0 for topic in RESULTS}
        self.last = {}
        self.poses = []  # stamp, x, y, yaw, when it came
        self.map_from_odom = 0
        self.stop = False
        self.readers = {}
        for topic, (kind, qos) in RESULTS.items():
            self.readers[topic] = DataReader(participant, Topic(participant, "rt" + topic, kind), qos=qos)
        self.waits = WaitSet(participant)
        for reader in self.readers.values():
            self.waits.attach(ReadCondition(reader, ViewState.Any | InstanceState.Any | SampleState.NotRead))
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        while not self.stop:
            self.waits.wait(duration(milliseconds=100))
            for topic, reader in self.readers.items():
                for message in reader.take(N=100):
                    if message.__class__.__name__ == "InvalidSample":
                        continue
                    self.accept(topic, message, time.time_ns())

    def accept(self, topic, message, came):
        if topic == "/tf":
            ours = [t for t in message.transforms if t.header.frame_id == "map"]
            self.map_from_odom += len(ours)
            self.counts[topic] += bool(ours)
            return
        self.counts[topic] += 1
        self.last[topic] = message
        if topic == "/visloc/pose":
            p, q = message.pose.pose.position, message.pose.pose.orientation
            self.poses.append((stamp(message.header), p.x, p.y, 2 * math.atan2(q.z, q.w), came))


def writer_for(participant, topic, kind):
    is_sensor = kind in (ros.CompressedImage, ros.CameraInfo)
    return DataWriter(participant, Topic(participant, "rt" + topic, kind), qos=SENSOR if is_sensor else RELIABLE)


def load(path):
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            if schema.name in ros.FROM_BAG:
                kind, convert = ros.FROM_BAG[schema.name]
                yield message.log_time, channel.topic, kind, convert(decoded)


def wait_for_reader(writer, seconds):
    end = time.time() + seconds
    while time.time() < end:
        if len(writer.get_matched_subscriptions()) > 0:
            return True
        time.sleep(0.05)
    return False


def play(participant, bag, args, sent):
    writers = {topic: writer_for(participant, topic, kind) for topic, kind in bag["topics"].items()}
    image_topic = next(topic for topic, kind in bag["topics"].items() if kind is ros.CompressedImage)
    if not wait_for_reader(writers[image_topic], args.wait):
        sys.exit("nobody subscribes to " + image_topic)
    time.sleep(1.0)  # the other topics
    start, first = time.perf_counter(), bag["messages"][0][0]
    num_images, held_back = 0, []
    for at, topic, message in bag["messages"]:
        ahead = (at - first) * 1e-9 / args.rate - (time.perf_counter() - start)
        if ahead > 0:
            time.sleep(ahead)
        if topic == image_topic:
            num_images += 1
            if args.drop and num_images % args.drop == 0:
                continue
            sent[stamp(message.header)] = time.time_ns()
            if args.late and num_images % args.late == 0:
                held_back.append(message)
                continue
            writers[topic].write(message)
            if held_back and num_images % args.late == 2:
                writers[topic].write(held_back.pop())
        else:
            writers[topic].write(message)
    return num_images


def headers_of(message):
    """The headers of a message and of all transforms in it, each with the time that it tells."""
    headers = [message.header] if hasattr(message, "header") else []
    headers += [transform.header for transform in getattr(message, "transforms", [])]
    return [(header, stamp(header)) for header in headers]


def play_for(participant, bag, minutes, args):
    """Plays the bag again and again; how many images were sent."""
    writers = {topic: writer_for(participant, topic, kind) for topic, kind in bag["topics"].items()}
    image_topic = next(topic for topic, kind in bag["topics"].items() if kind is ros.CompressedImage)
    if not wait_for_reader(writers[image_topic], args.wait):
        sys.exit("nobody subscribes to " + image_topic)
    time.sleep(1.0)
    first, last = bag["messages"][0][0], bag["messages"][-1][0]
    frame = (last - first) / max(1, sum(topic == image_topic for _, topic, _ in bag["messages"]) - 1)
    messages = [(at, topic, message, headers_of(message)) for at, topic, message in bag["messages"]]
    start, num_images, round_start = time.time_ns(), 0, time.time_ns()
    while time.time_ns() < start + minutes * 60e9:
        for at, topic, message, headers in messages:
            ahead = (round_start + (at - first) - time.time_ns()) * 1e-9
            if ahead > 0:
                time.sleep(ahead)
            # What was stamped alike in the bag is so again.
            for header, stamped in headers:
                header.stamp.sec, header.stamp.nanosec = divmod(round_start + (stamped - first), 1_000_000_000)
            num_images += topic == image_topic
            writers[topic].write(message)
        round_start += int(last - first + frame)
    return num_images


def give_orders(participant):
    """After four seconds forgets the pose, after six names one."""
    reset = DataWriter(participant, Topic(participant, "rt/visloc/reset", ros.Empty), qos=RELIABLE)
    pose = DataWriter(participant, Topic(participant, "rt/initialpose", ros.PoseWithCovarianceStamped), qos=RELIABLE)
    wait_for_reader(reset, 30.0)
    time.sleep(4.0)
    reset.write(ros.Empty(0))
    time.sleep(2.0)
    covariance = [0.25 if i in (0, 7) else 0.1 if i == 35 else 0.0 for i in range(36)]
    where = ros.Pose(ros.Vector3(-1.4, 1.1, 0.0), ros.Quaternion(0.0, 0.0, 0.0, 1.0))
    header = ros.Header(ros.Time(0, 0), "map")
    pose.write(ros.PoseWithCovarianceStamped(header, ros.PoseWithCovariance(where, covariance)))
    time.sleep(2.0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bag")
    parser.add_argument("--rate", type=float, default=1.0, help="times real time")
    parser.add_argument("--wait", type=float, default=30.0, help="seconds to wait for a subscriber")
    parser.add_argument("--domain", type=int, default=0)
    parser.add_argument("--received", help="write the poses that came to this CSV file")
    parser.add_argument("--json", help="write counts and delays to this file")
    parser.add_argument("--drop", type=int, default=0, help="leave out every so manyeth image")
    parser.add_argument("--late", type=int, default=0, help="send every so manyeth image after the next two")
    parser.add_argument("--wrong-type", action="store_true", help="publish Bool on the topic of the images, nothing else")
    parser.add_argument("--again", action="store_true", help="leave after the end, and play all from the start once more")
    parser.add_argument("--orders", action="store_true", help="reset after four seconds, initial pose after six")
    parser.add_argument("--minutes", type=float, help="play over and over for so long, stamped as if it happened now")
    args = parser.parse_args()

    bag = {"topics": {}, "messages": []}
    for at, topic, kind, message in load(args.bag):
        bag["topics"][topic] = kind
        bag["messages"].append((at, topic, message))
    # Looking for cycles, of which there are none, would hold up what is sent for a tenth of a second now and then.
    gc.disable()
    participant = DomainParticipant(args.domain)
    if args.wrong_type:
        writer = writer_for(participant, "/camera/image/compressed", ros.Bool)
        for _ in range(120):
            writer.write(ros.Bool(True))
            time.sleep(0.1)
        return
    results, sent = Results(participant), {}
    if args.orders:
        threading.Thread(target=give_orders, args=(participant,), daemon=True).start()
    players = DomainParticipant(args.domain)
    num_images = play_for(players, bag, args.minutes, args) if args.minutes else play(players, bag, args, sent)
    if args.again:
        del players
        time.sleep(5.0)
        num_images += play(DomainParticipant(args.domain), bag, args, sent)
    time.sleep(1.5)
    results.stop = True
    results.thread.join()

    # An endless replay sends each message at its stamp.
    is_sent = (lambda at: True) if args.minutes else sent.__contains__
    answers = [(at, (came - sent.get(at, at)) * 1e-6) for at, _, _, _, came in results.poses if is_sent(at)]
    delays = sorted(delay for _, delay in answers)
    longest = sorted(answers, key=lambda answer: -answer[1])[:5]
    summary = {
        "images": num_images,
        "counts": results.counts,
        "map_from_odom": results.map_from_odom,
        "delay_ms": {
            "median": delays[len(delays) // 2], "p95": delays[int(0.95 * (len(delays) - 1))], "max": delays[-1],
            "later_than_100": sum(delay > 100 for delay in delays), "num": len(delays),
            "longest": [{"after_s": (at - answers[0][0]) * 1e-9, "ms": delay} for at, delay in longest],
        } if delays else None,
    }
    if "/diagnostics" in results.last:
        status = results.last["/diagnostics"].status[0]
        summary["diagnostics"] = {"message": status.message, **{v.key: v.value for v in status.values}}
    if "/visloc/path" in results.last:
        summary["path_poses"] = len(results.last["/visloc/path"].poses)
    if "/visloc/points" in results.last:
        summary["points"] = results.last["/visloc/points"].width
    print(json.dumps(summary, indent=2))
    if args.json:
        with open(args.json, "w") as file:
            json.dump(summary, file)
    if args.received:
        with open(args.received, "w", newline="") as file:
            table = csv.writer(file)
            table.writerow(["t", "x", "y", "yaw"])
            for at, x, y, yaw, _ in results.poses:
                table.writerow([f"{at // 10**9}.{at % 10**9:09d}", x, y, yaw])


if __name__ == "__main__":
    main()
