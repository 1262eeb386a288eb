"""Writes the first frames of a recording as SQLite and as a ROS 1 bag, with rosbags.

    make_bags.py RECORDING.mcap FOLDER NUM_FRAMES
"""

import shutil
import sys
from pathlib import Path

from mcap.reader import make_reader
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.rosbag2.enums import StoragePlugin
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

IMAGES = "/camera/image/compressed"


def first_messages(recording: Path, num_frames: int):
    """Topic, type, time and bytes of all messages up to those frames."""
    messages, num_images = [], 0
    with recording.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages(log_time_order=False):
            if channel.topic == IMAGES:
                if num_images == num_frames:
                    break
                num_images += 1
            messages.append((channel.topic, schema.name, message.log_time, message.data))
    return messages


def write_sqlite(path: Path, messages, ros2) -> None:
    folder = path.with_suffix(".folder")
    with Ros2Writer(folder, version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connections = {}
        for topic, name, nanos, data in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=ros2)
            writer.write(connections[topic], nanos, data)
    shutil.move(next(folder.glob("*.db3")), path)
    shutil.rmtree(folder)


def to_ros1(value, ros1):
    """The same message in the types of ROS 1: the header has a number, CameraInfo capitals."""
    if isinstance(value, list):
        return [to_ros1(item, ros1) for item in value]
    if not hasattr(value, "__msgtype__"):
        return value
    name = value.__msgtype__
    fields = {}
    for key in ros1.types[name].__dataclass_fields__:
        if name == "std_msgs/msg/Header" and key == "seq":
            fields[key] = 7
        elif key != "__msgtype__":
            known_as = key.lower() if name == "sensor_msgs/msg/CameraInfo" else key
            fields[key] = to_ros1(getattr(value, known_as), ros1)
    return ros1.types[name](**fields)


def write_ros1(path: Path, messages, ros2) -> None:
    ros1 = get_typestore(Stores.ROS1_NOETIC)
    ros1.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage"))
    writer = Ros1Writer(path)
    writer.set_compression(Ros1Writer.CompressionFormat.BZ2)
    with writer:
        connections = {}
        for topic, name, nanos, data in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=ros1)
            message = to_ros1(ros2.deserialize_cdr(data, name), ros1)
            writer.write(connections[topic], nanos, ros1.serialize_ros1(message, name))


def main() -> None:
    recording, folder, num_frames = Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3])
    messages = first_messages(recording, num_frames)
    name = recording.stem.removesuffix("-excerpt") + "-first-frames"
    ros2 = get_typestore(Stores.ROS2_HUMBLE)
    write_sqlite(folder / f"{name}.db3", messages, ros2)
    write_ros1(folder / f"{name}.bag", messages, ros2)


main()
