"""Kills visloc at random moments and checks what is left. See .ci/kill9."""

import json
import random
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader
from mcap.records import Chunk
from mcap.stream_reader import StreamReader

# Of the recording's time, seconds: what may be missing at the end of a file.
MOST_MISSING = 1.0

COMMANDS = {
    "record loop:": "record loop:{images} --fps 30 --out {out}/loop.mcap",
    "simulate": "simulate tour --frames 250 --out {out}/sim.mcap --json {out}/sim.json",
    "localize": "localize sim:tour --frames 200 --bag-out {out}/bag --record {out}/studio.mcap --estimates {out}/r.csv "
    "--trajectory {out}/r.tum --json {out}/r.json --plots {out}/plots",
    "slam": "slam sim:room --end 120 --points {out}/map.ply --save {out}/room.vmap --record {out}/slam.mcap --trajectory {out}/s.tum "
    "--log {out}/s.csv --json {out}/s.json --plots {out}/plots",
}


def read(path):
    """Stamps (seconds) of all messages that can be read, and whether the file lacks its end."""
    stamps, is_cut = [], False
    with open(path, "rb") as file:
        try:
            for _, _, message in NonSeekingReader(file).iter_messages(log_time_order=False):
                stamps.append(message.log_time / 1e9)
        except EndOfFile:
            is_cut = True
    return stamps, is_cut


def longest_chunk(path):
    """No more than this is in memory while it is written, seconds."""
    longest = 0.0
    with open(path, "rb") as file:
        try:
            for record in StreamReader(file, emit_chunks=True).records:
                if isinstance(record, Chunk):
                    longest = max(longest, (record.message_end_time - record.message_start_time) / 1e9)
        except EndOfFile:
            pass
    return longest


def check_whole(path):
    """A file that is no recording is complete, or has not got its name yet."""
    data = path.read_bytes()
    if path.suffix == ".json":
        json.loads(data)
    elif path.suffix in (".csv", ".tum"):
        assert data.endswith(b"\n"), f"{path}: the last line is cut"
    elif path.suffix == ".ply":
        head, _, body = data.partition(b"end_header\n")
        count = sum(int(line.split()[2]) for line in head.split(b"\n") if line.startswith(b"element "))
        found = body.count(b"\n")
        assert found == count, f"{path}: {found} of {count} points and edges"
    elif path.suffix in (".vmap", ".vmap~"):
        length = int.from_bytes(data[-8:], "little")
        assert data[:length] == data[-8 - length : -8], f"{path}: the head at the end is another one"
    elif path.suffix == ".png":
        assert data.endswith(b"IEND\xaeB`\x82"), f"{path}: cut"
    elif path.suffix == ".svg":
        assert data.rstrip().endswith(b"</svg>"), f"{path}: cut"
    elif path.suffix == ".yaml":
        assert b"message_count" in data.splitlines()[-1], f"{path}: cut"
    else:
        assert False, f"{path}: what is this?"


def start(visloc, command, images, out):
    words = command.format(images=images, out=out).split()
    return subprocess.Popen([visloc, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def check(out, name, killed_at, tally):
    lasts = []
    for path in sorted(p for p in out.rglob("*") if p.is_file()):
        if path.suffix == ".part":
            tally["unfinished"] += 1
        elif path.suffix == ".mcap":
            if path.stat().st_size == 0:
                tally["without a frame yet"] += 1
                continue
            stamps, is_cut = read(path)
            tally["recordings"] += 1
            tally["without their end"] += is_cut
            tally["messages"] += len(stamps)
            longest = longest_chunk(path)
            assert longest <= MOST_MISSING, f"{path}: a part of {longest} s"
            if stamps:
                lasts.append(max(stamps))
            if name == "record loop:" and stamps:
                missing = killed_at - max(stamps)
                tally["most missing"] = max(tally["most missing"], missing)
                assert missing <= MOST_MISSING, f"{path}: the last {missing:.2f} s are missing"
        else:
            check_whole(path)
            tally["complete files"] += 1
    # Two recordings of one run end together.
    if len(lasts) == 2:
        apart = abs(lasts[0] - lasts[1])
        tally["most apart"] = max(tally["most apart"], apart)
        assert apart <= MOST_MISSING, f"{out}: the recordings end {apart:.2f} s apart"


def make_images(folder):
    folder.mkdir()
    size = "testsrc=size=320x240:rate=30:duration=2"
    made = subprocess.run(["ffmpeg", "-v", "error", "-f", "lavfi", "-i", size, str(folder / "%04d.jpg")], check=False)
    return made.returncode == 0


def main():
    visloc, num_moments, seed = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    draw = random.Random(seed)
    tally = dict.fromkeys(
        ["killed", "ended before", "recordings", "messages", "without their end", "without a frame yet", "complete files",
         "unfinished", "most missing", "most apart"], 0)
    with tempfile.TemporaryDirectory() as scratch:
        images = Path(scratch) / "images"
        commands = dict(COMMANDS)
        if not shutil.which("ffmpeg") or not make_images(images):
            del commands["record loop:"]
            print("left out: record loop: (there is no ffmpeg)")
        lengths = {}
        for name, command in commands.items():
            begun = time.monotonic()
            if name == "record loop:":
                lengths[name] = 4.0
                continue
            start(visloc, command, images, Path(scratch) / f"whole-{name}").wait()
            lengths[name] = time.monotonic() - begun
        print("whole runs take", {name: round(secs, 1) for name, secs in lengths.items()}, "s")
        for moment in range(num_moments):
            name = list(commands)[moment % len(commands)]
            out = Path(scratch) / f"{moment}"
            out.mkdir()
            process = start(visloc, commands[name], images, out)
            time.sleep(0.1 + draw.random() * lengths[name])
            killed_at = time.time()
            process.kill()
            tally["killed" if process.wait() == -9 else "ended before"] += 1
            check(out, name, killed_at, tally)
            shutil.rmtree(out)
    for what, count in tally.items():
        print(f"{what:<24} {count:.2f} s" if what.startswith("most") else f"{what:<24} {count}")


if __name__ == "__main__":
    main()
