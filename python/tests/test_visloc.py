"""The wheel against the program and against truth. VISLOC names the program; without it the comparison is left out."""

import json
import os
import subprocess
import threading
from pathlib import Path

import numpy as np
import pytest

import visloc

TESTDATA = Path(__file__).parents[2] / "testdata"


def localized(source, name, **settings):
    localizer = visloc.Localizer(visloc.Map(name), **settings)
    return [(frame, localizer.step(frame)) for frame in visloc.frames(str(source))]


def test_a_bag_is_localized_as_by_the_program(tmp_path):
    program = os.environ.get("VISLOC")
    if not program:
        pytest.skip("VISLOC does not name the program")
    bag = TESTDATA / "R1-excerpt.mcap"
    csv = tmp_path / "estimates.csv"
    arguments = ["localize", str(bag), "--map", "robocup-spl-2010", "--seed", "3", "--estimates", str(csv)]
    subprocess.run([program, *arguments], check=True, capture_output=True)
    header, *lines = csv.read_text().splitlines()
    columns = {name: i for i, name in enumerate(header.split(","))}
    ours = [estimate for _, estimate in localized(bag, "robocup-spl-2010", seed=3)]
    assert len(ours) == len(lines)
    for line, estimate in zip(lines, ours):
        values = line.split(",")
        for name, value in [("x", estimate.x_m), ("y", estimate.y_m), ("reliability", estimate.reliability)]:
            printed = values[columns[name]]
            assert float(printed) == pytest.approx(value, abs=0.6 * 10 ** -len(printed.partition(".")[2]))


def test_errors_are_the_program_s_to_the_last_bit(tmp_path):
    program = os.environ.get("VISLOC")
    if not program:
        pytest.skip("VISLOC does not name the program")
    simulated = tmp_path / "tour.mcap"
    subprocess.run([program, "simulate", "tour", "--frames", "120", "--out", str(simulated)], check=True, capture_output=True)
    for bag in (TESTDATA / "R1-excerpt.mcap", simulated):
        numbers = tmp_path / "run.json"
        arguments = ["localize", str(bag), "--map", "robocup-spl-2010", "--seed", "7", "--json", str(numbers)]
        subprocess.run([program, *arguments], check=True, capture_output=True)
        rows = [
            ((frame.at_s, *frame.truth), (frame.at_s, estimate.x_m, estimate.y_m, estimate.yaw_rad), estimate.reliability)
            for frame, estimate in localized(bag, "robocup-spl-2010", seed=7)
        ]
        ours = visloc.evaluate_robot(*(np.array(part) for part in zip(*rows)))
        theirs = json.loads(numbers.read_text())
        for name in ("position_error_m", "heading_error_deg", "tracking_position_error_m", "localized_share"):
            assert ours[name] == theirs[name], f"{bag.name}: {name}"


def test_a_simulated_robot_is_found():
    frames = visloc.frames("sim:robocup", seed=5)
    localizer = visloc.Localizer(frames.map, seed=5)
    rows, truth, reliability = [], [], []
    for frame, _ in zip(frames, range(300)):
        estimate = localizer.step(frame)
        rows.append((frame.at_s, estimate.x_m, estimate.y_m, estimate.yaw_rad))
        truth.append((frame.at_s, *frame.truth))
        reliability.append(estimate.reliability)
    result = visloc.evaluate_robot(np.array(truth), np.array(rows), np.array(reliability))
    assert result["localized_share"] > 0.5
    assert result["tracking_position_error_m"]["median"] < 0.05
    assert estimate.covariance.shape == (3, 3) and np.all(np.linalg.eigvalsh(estimate.covariance) >= 0)


def test_slam_follows_a_clip_and_is_repeatable():
    def run():
        source = visloc.images(str(TESTDATA / "desk-clip"))
        slam = visloc.Slam(source.camera, seed=2)
        states = [slam.add_image(at_s, image).state for at_s, image in source]
        slam.finish()
        return states, slam

    states, slam = run()
    assert states[0] == "starting" and states.count("tracking") > len(states) / 2
    assert slam.landmarks().shape[1] == 3 and slam.num_keyframes >= 2
    times, poses = (np.array(part) for part in zip(*slam.trajectory()))
    again = run()[1].trajectory()
    assert all(np.array_equal(pose, other) for pose, (_, other) in zip(poses, again))
    error = visloc.evaluate_camera(times, poses, times, poses)
    assert error["rmse"] < 1e-9 and error["pairs"] == len(times)
    assert sum(len(slam.trajectory(number)) for number in slam.maps) == len(times)


def test_a_camera_is_found_in_a_map_that_was_saved(tmp_path):
    source = visloc.images(str(TESTDATA / "desk-clip"))
    slam = visloc.Slam(source.camera, seed=2)
    images = list(source)
    for at_s, image in images:
        slam.add_image(at_s, image)
    slam.save(tmp_path / "desk.vmap")
    final = dict(slam.trajectory())

    taught = visloc.VisualMap.load(tmp_path / "desk.vmap")
    assert taught.num_keyframes == slam.num_keyframes and not taught.damages and not taught.is_in_meters
    localizer = visloc.MapLocalizer(taught, source.camera)
    estimates = [(at_s, localizer.step(at_s, image)) for at_s, image in images]
    found = [(at_s, estimate) for at_s, estimate in estimates if estimate and estimate.is_localized]
    assert len(found) > 0.9 * len(images)
    depth = np.median(np.linalg.norm(slam.landmarks(), axis=1))
    for at_s, estimate in found:
        assert estimate.support == "map" and estimate.covariance.shape == (6, 6)
        if at_s in final:
            assert np.linalg.norm(estimate.world_from_camera[:3, 3] - final[at_s][:3, 3]) < 0.05 * depth
    with pytest.raises(visloc.VislocError):
        visloc.VisualMap.load(tmp_path / "no.vmap")


def test_images_of_any_layout_are_taken():
    camera = visloc.Camera((64, 48), (60.0, 60.0), (31.5, 23.5))
    color = np.zeros((48, 64, 3), np.uint8)
    for image in (color, color[:, ::-1], color[..., 0], np.asfortranarray(color)):
        frame = visloc.Frame(0.0, image, camera, height_m=0.5, tilt_rad=0.2)
        assert frame.image.shape == (48, 64, 3)
    for wrong in (color.astype(np.float32), np.zeros((48, 64, 4), np.uint8), None):
        with pytest.raises(visloc.VislocError, match="expected uint8"):
            visloc.Frame(0.0, wrong, camera, height_m=0.5)


def test_what_is_wrong_is_said():
    with pytest.raises(visloc.VislocError, match="robocup-spl-2010"):
        visloc.Map("no-such-map")
    with pytest.raises(visloc.VislocError, match="unknown algorithm"):
        visloc.Localizer(visloc.Map("robocup-spl-2010"), "magic")
    with pytest.raises(visloc.VislocError, match="num_particles"):
        visloc.Localizer(visloc.Map("robocup-spl-2010"), "mc", parameters={"num_particels": 3})
    with pytest.raises(visloc.VislocError, match="expected"):
        visloc.Frame(0.0, np.zeros((4, 4), np.uint8), visloc.Camera((4, 4), (4, 4), (2, 2)))


def test_a_camera_projects_and_looks_back():
    camera = visloc.Camera((640, 480), (521.3, 523.1), (323.8, 236.4), [-0.25, 0.09, 8e-4, -6e-4, -0.01])
    points = np.array([[0.1, -0.2, 1.0], [0.5, 0.3, 2.0], [0.0, 0.0, -1.0]])
    pixels = camera.project(points)
    assert np.isnan(pixels[2]).all()
    expected = points[:2] / np.linalg.norm(points[:2], axis=1, keepdims=True)
    bearing = camera.bearing(pixels[:2])
    assert np.allclose(bearing / np.linalg.norm(bearing, axis=1, keepdims=True), expected, atol=1e-6)


def test_other_threads_run_during_a_step():
    frames = visloc.frames("sim:robocup", seed=1)
    localizer = visloc.Localizer(frames.map)
    count, is_over = 0, threading.Event()

    def other():
        nonlocal count
        while not is_over.is_set():
            count += 1

    thread = threading.Thread(target=other)
    thread.start()
    for frame, _ in zip(frames, range(30)):
        localizer.step(frame)
    is_over.set()
    thread.join()
    assert count > 1000


def test_results_go_to_json():
    rows = np.array([[0.0, 0.0, 0.0, 0.0], [1.0, 0.1, 0.0, 0.0]])
    assert json.loads(json.dumps(visloc.evaluate_robot(rows, rows)))["frames"] == 2
