"""What a frame costs in Python beside the program, in processor time: overhead.py PROGRAM BAG MAP. Prints; does not judge."""

import os
import resource
import subprocess
import sys
import time

os.environ["RAYON_NUM_THREADS"] = "1"
import visloc  # noqa: E402

program, bag, name = sys.argv[1:]


def in_the_program():
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([program, "localize", bag, "--map", name], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def in_python():
    global num_frames
    begin, num_frames = time.process_time(), 0
    localizer = visloc.Localizer(visloc.Map(name))
    for frame in visloc.frames(bag):
        localizer.step(frame)
        num_frames += 1
    return time.process_time() - begin


def in_python_with_arrays():
    """As who draws its own frames: image out, image in."""
    begin = time.process_time()
    localizer = visloc.Localizer(visloc.Map(name))
    for frame in visloc.frames(bag):
        mine = visloc.Frame(frame.at_s, frame.image, frame.camera, robot_from_camera=frame.robot_from_camera, odometry=frame.odometry)
        localizer.step(mine).covariance
    return time.process_time() - begin


least = {way.__name__: min(way() for _ in range(5)) for way in (in_the_program, in_python, in_python_with_arrays)}
for way, seconds in least.items():
    print(f"{way}: {seconds / num_frames * 1e3:.3f} ms of processor time a frame, {num_frames} frames, least of 5")
