"""Follows a camera without a map, and draws its way: slam_images.py [SOURCE | WEBCAM NUMBER] [CAMERA FILE]

SOURCE is a folder of images, a dataset, a bag; a number is a webcam and needs opencv-python and a camera file."""

import sys
import time

import numpy as np

import visloc

source = sys.argv[1] if len(sys.argv) > 1 else "testdata/desk-clip"
camera = sys.argv[2] if len(sys.argv) > 2 else None


def webcam(number):
    import cv2

    device, start = cv2.VideoCapture(number), time.monotonic()
    while (grabbed := device.read())[0]:
        yield time.monotonic() - start, cv2.cvtColor(grabbed[1], cv2.COLOR_BGR2GRAY)


if source.isdigit():
    images, slam = webcam(int(source)), visloc.Slam(visloc.Camera.load(camera))
else:
    images = visloc.images(source, camera=camera)
    slam = visloc.Slam(images.camera)
try:
    for at_s, image in images:
        outcome = slam.add_image(at_s, image)
        print(f"{at_s:.2f} s: {outcome.state}, {outcome.matches[0]} landmarks", end="\r")
except KeyboardInterrupt:
    pass
slam.finish()
way = np.array([pose[:3, 3] for _, pose in slam.trajectory()])
print(f"\n{len(way)} poses, {len(slam.landmarks())} landmarks, {slam.num_keyframes} keyframes")
try:
    import matplotlib.pyplot as plt
except ImportError:
    sys.exit()
landmarks = slam.landmarks()
plt.plot(landmarks[:, 0], landmarks[:, 2], ".", markersize=1, color="gray")
plt.plot(way[:, 0], way[:, 2])
plt.axis("equal")
plt.savefig("slam.png", dpi=150)
