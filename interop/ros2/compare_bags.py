"""Compares a recording with its copy by visloc, both as rosbags reads them: topics, types, counts, times and values.

    compare_bags.py ORIGINAL COPY
"""

import re
import sys
from pathlib import Path

import numpy as np
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.typesys import Stores, get_typestore


def ros2_name(name: str) -> str:
    """Fields of ROS 2 are lower case."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def plain(value):
    """A message as nested dictionaries, without what ROS 2 does not have."""
    if hasattr(value, "__msgtype__"):
        is_header = value.__msgtype__ == "std_msgs/msg/Header"
        names = [name for name in value.__dataclass_fields__ if name != "__msgtype__"]
        names = [name for name in names if not (is_header and name == "seq")]
        names = [name for name in names if name != "structure_needs_at_least_one_member"]
        return {ros2_name(name): plain(getattr(value, name)) for name in names}
    if isinstance(value, np.ndarray):
        return ("array", value.tobytes())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    # What is not a number is equal here.
    return "nan" if isinstance(value, float) and value != value else value


def read_paths(paths):
    messages, types = [], {}
    with AnyReader(paths, default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        for connection, nanos, data in reader.messages():
            # Types of the first releases of ROS 2 lack the middle part.
            name = connection.msgtype
            types[connection.topic] = name if name.count("/") == 2 else name.replace("/", "/msg/")
            try:
                values = plain(reader.deserialize(data, connection.msgtype))
            except Exception as error:  # noqa: BLE001 rosbags raises what it likes for types that it does not know
                values = f"not decoded: {type(error).__name__}"
            messages.append((connection.topic, nanos, values, bytes(data)))
    messages.sort(key=lambda message: (message[0], message[1], repr(message[2]), message[3]))
    return types, messages


def read(path: Path):
    """Topics with types, and messages by topic and time; values where rosbags can tell them."""
    try:
        types, messages = read_paths([path])
    except AnyReaderError:
        # rosbags refuses folders whose metadata.yaml names an encoding that it does not know, but reads their files.
        if not path.is_dir():
            raise
        types, messages = {}, []
    if not messages and path.is_dir():
        # rosbags skips topics whose quality of service differs between metadata.yaml and files.
        types, messages = read_paths(sorted([*path.glob("*.mcap"), *path.glob("*.db3")]))
    return types, messages


def main() -> int:
    original, copy = Path(sys.argv[1]), Path(sys.argv[2])
    is_ros1 = original.suffix == ".bag"
    try:
        types, messages = read(original)
    except Exception as error:  # noqa: BLE001 what rosbags cannot read cannot be compared with it
        print(f"not compared, rosbags cannot read the original: {str(error).splitlines()[0]}")
        return 0
    copied_types, copied = read(copy)
    if types != copied_types:
        print(f"DIFFERENT types: {types} and {copied_types}")
        return 1
    if len(messages) != len(copied):
        print(f"DIFFERENT counts: {len(messages)} and {len(copied)}")
        return 1
    num_decoded = 0
    for (topic, nanos, values, data), (other_topic, other_nanos, other_values, other_data) in zip(messages, copied):
        if (topic, nanos) != (other_topic, other_nanos):
            print(f"DIFFERENT times: {topic} {nanos} and {other_topic} {other_nanos}")
            return 1
        is_decoded = not isinstance(values, str)
        num_decoded += is_decoded
        if (is_ros1 or is_decoded) and values != other_values:
            print(f"DIFFERENT values on {topic} at {nanos}: {str(values)[:300]} and {str(other_values)[:300]}")
            return 1
        if not is_ros1 and data != other_data:
            print(f"DIFFERENT bytes on {topic} at {nanos}")
            return 1
    print(f"same: {len(types)} topics, {len(messages)} messages, {num_decoded} of them compared by value")
    return 0


sys.exit(main())
