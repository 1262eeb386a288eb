"""Localizes a robot in a bag, and compares with the truth if the bag has it: localize_bag.py [BAG] [MAP]"""

import sys

import numpy as np

import visloc

bag = sys.argv[1] if len(sys.argv) > 1 else "testdata/R1-excerpt.mcap"
localizer = visloc.Localizer(visloc.Map(sys.argv[2] if len(sys.argv) > 2 else "robocup-spl-2010"))
poses, truth, reliability = [], [], []
for frame in visloc.frames(bag):
    estimate = localizer.step(frame)
    poses.append((frame.at_s, estimate.x_m, estimate.y_m, estimate.yaw_rad))
    reliability.append(estimate.reliability)
    if frame.truth:
        truth.append((frame.at_s, *frame.truth))
print(f"{len(poses)} frames, {np.mean(np.array(reliability) > 0.6):.0%} localized, at the end {estimate}")
if truth:
    result = visloc.evaluate_robot(np.array(truth), np.array(poses), np.array(reliability))
    print(f"median error while localized: {result['tracking_position_error_m']['median']:.3f} m")
