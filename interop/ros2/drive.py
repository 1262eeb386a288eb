"""Drives a robot over the link of `visloc ... --publish ADDRESS --allow-drive`, and receives through Cyclone DDS what the robot is told.

    python drive.py OUTPUT_OF_VISLOC [--domain N]

Waits for the address in what visloc prints, drives ahead for two seconds, turns the head, and cuts the link with the key still held. Fails
unless the robot is told to go, then within half a second to stand, and then nothing.
"""

import argparse
import base64
import json
import os
import re
import socket
import struct
import threading
import time
import zlib

from cyclonedds.domain import DomainParticipant
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

import messages as ros

RELIABLE = Qos(Policy.Reliability.Reliable(10**8), Policy.History.KeepLast(100))


class Desk:
    """A WebSocket by hand."""

    def __init__(self, host, port, token):
        self.socket = socket.create_connection((host, port))
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(
            f"GET /socket?token={token} HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n".encode()
        )
        self.buffer = b""
        while b"\r\n\r\n" not in self.buffer:
            self.buffer += self.socket.recv(4096)
        head, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        assert b" 101 " in head, head
        self.drive, self.refused = None, []
        threading.Thread(target=self.listen, daemon=True).start()

    def read(self, count):
        while len(self.buffer) < count:
            more = self.socket.recv(1 << 16)
            if not more:
                raise OSError("closed")
            self.buffer += more
        data, self.buffer = self.buffer[:count], self.buffer[count:]
        return data

    def listen(self):
        try:
            while True:
                code, length = self.read(2)
                if length >= 126:
                    length = struct.unpack(*((">H", self.read(2)) if length == 126 else (">Q", self.read(8))))[0]
                self.take(code & 15, self.read(length))
        except OSError:
            pass

    def take(self, code, body):
        if code == 1:
            told = json.loads(body)
            self.refused += [told["reason"]] if told["type"] == "refused" else []
        elif code == 2 and body[0] == 2:
            content = zlib.decompress(body[8:], -15) if body[1] else body[8:]
            self.drive = json.loads(content[: struct.unpack("<I", body[4:8])[0]])["drive"]
            self.send("drawn")

    def send(self, text):
        data, mask = text.encode(), os.urandom(4)
        masked = bytes(byte ^ mask[i % 4] for i, byte in enumerate(data))
        size = struct.pack(">BB", 0x81, 0x80 | len(data)) if len(data) < 126 else struct.pack(">BBH", 0x81, 0xFE, len(data))
        self.socket.sendall(size + mask + masked)

    def cut(self):
        """The link is lost: nothing is said any more."""
        self.socket.shutdown(socket.SHUT_RDWR)


def address_in(path, patience_secs=60):
    for _ in range(10 * patience_secs):
        found = re.search(r"--connect (\S+):(\d+) --token (\S+)", open(path).read())
        if found:
            return found[1], int(found[2]), found[3]
        time.sleep(0.1)
    raise SystemExit(f"{path}: no address within {patience_secs} s")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output")
    parser.add_argument("--domain", type=int, default=0)
    args = parser.parse_args()
    participant = DomainParticipant(args.domain)
    speeds = DataReader(participant, Topic(participant, "rt/cmd_vel", ros.Twist), qos=RELIABLE)
    name = "rt/head_controller/joint_trajectory"
    heads = DataReader(participant, Topic(participant, name, ros.JointTrajectory), qos=RELIABLE)
    told, looks = [], []

    def listen(secs):
        until = time.time() + secs
        while time.time() < until:
            told.extend((time.time(), twist) for twist in speeds.take(N=100) if isinstance(twist, ros.Twist))
            looks.extend(look for look in heads.take(N=100) if isinstance(look, ros.JointTrajectory))
            time.sleep(0.01)

    desk = Desk(*address_in(args.output))
    while desk.drive is None:
        time.sleep(0.05)
    listen(1.0)
    assert not told, "nobody drives yet"
    desk.send(json.dumps({"type": "head", "yaw_deg": 30, "pitch_deg": 10}))
    for _ in range(20):
        desk.send(json.dumps({"type": "drive", "forward": 1, "left": 0, "turn": -1, "seen_secs": desk.drive["secs"]}))
        listen(0.1)
    assert not desk.refused, desk.refused
    cut_at = time.time()
    desk.cut()
    listen(3.0)
    going = [(at, twist) for at, twist in told if twist.linear.x != 0]
    standing = [at for at, twist in told if twist.linear.x == 0 and twist.angular.z == 0]
    assert len(going) > 20, f"told to go {len(going)} times"
    fastest = max(twist.linear.x for _, twist in going)
    assert abs(fastest - 0.3) < 1e-9, fastest
    stops_after = going[-1][0] - cut_at
    assert stops_after < 0.5, f"goes on for {stops_after:.2f} s"
    assert standing and standing[-1] - cut_at < 1.5, "left alone after a moment"
    assert [look.joint_names for look in looks] == [["head_pan_joint", "head_tilt_joint"]], looks
    print(
        f"driven: {len(going)} speeds of {fastest:.2f} m/s, the last one {max(stops_after, 0):.2f} s after the link was cut, "
        f"then {len(standing)} times to stand; the head once"
    )


if __name__ == "__main__":
    main()
