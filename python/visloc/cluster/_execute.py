"""One run, without Ray."""

import json
import platform
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

import visloc

from ._store import filesystem
from ._work import Run


@dataclass(frozen=True)
class Outcome:
    """What a run found."""

    row: dict[str, Any]
    """The run, its errors if the recording has the truth (names of ``evaluate_robot`` and ``evaluate_camera``), its times."""
    poses: dict[str, np.ndarray]
    """``at_s`` (N) and ``x_m``, ``y_m``, ``yaw_rad``, ``reliability``; or ``world_from_camera`` (N, 4, 4) with ``map`` (SLAM;
    errors are those of the map with the most poses) or ``reliability`` (in a taught map)."""


def execute(run: Run) -> Outcome:
    """Does a run here and now; recordings of other machines are fetched for its duration.

    :raises VislocError: what is wrong with the recording, the map or the parameters.
    """
    with ExitStack() as stack:
        source, map, camera = (stack.enter_context(_here(file)) for file in (run.source, run.map, run.camera))
        follow = _slam if run.command == "slam" else _in_taught_map if _is_taught(run.map) else _localize
        begin, begin_cpu = time.perf_counter(), time.process_time()
        found, poses = follow(replace(run, source=source or run.source, map=map, camera=camera))
        times = {"wall_s": time.perf_counter() - begin, "cpu_s": time.process_time() - begin_cpu}
    row = {
        **json.loads(run.to_json()),
        "parameters": json.dumps(dict(run.parameters), sort_keys=True),
        "key": run.key,
        "visloc": visloc.__version__,
        **_flat(found),
        **times,
        "host": platform.node(),
    }
    return Outcome(row, poses)


def _is_taught(map: str | None) -> bool:
    return map is not None and map.endswith(".vmap")


@contextmanager
def _here(address: str | None) -> Iterator[str | None]:
    """A file or folder of another machine as one of this, until the end."""
    if address is None or "://" not in address:
        yield address
        return
    fs, path = filesystem(address)
    with tempfile.TemporaryDirectory(prefix="visloc-") as folder:
        local = str(Path(folder) / path.rstrip("/").rsplit("/", 1)[-1])
        fs.get(path, local, recursive=fs.isdir(path))
        yield local


def _flat(values: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested results as columns; lists as JSON."""
    row: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, dict):
            row |= _flat(value, f"{prefix}{name}_")
        else:
            row[prefix + name] = json.dumps(value) if isinstance(value, list) else value
    return row


def _seed_of_source(run: Run) -> dict[str, int]:
    return {"seed": run.seed} if run.source.startswith("sim:") else {}


def _localize(run: Run) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    frames = visloc.frames(run.source, camera=run.camera, **_seed_of_source(run))
    known = visloc.Map(run.map) if run.map else frames.map
    if known is None:
        raise visloc.VislocError(f"{run.source}: expected a map, since this source knows none; name it with map=")
    localizer = visloc.Localizer(known, run.algorithm, seed=run.seed, parameters=dict(run.parameters) or None)
    rows, truth = [], []
    for frame in islice(frames, run.max_frames):
        estimate = localizer.step(frame)
        rows.append((frame.at_s, estimate.x_m, estimate.y_m, estimate.yaw_rad, estimate.reliability))
        if frame.truth:
            truth.append((frame.at_s, *frame.truth))
    columns = np.array(rows).reshape(-1, 5)
    poses = dict(zip(("at_s", "x_m", "y_m", "yaw_rad", "reliability"), columns.T))
    found = {"frames": len(rows), "skipped": len(frames.skipped), "video_s": _duration(poses["at_s"])}
    if truth:
        found |= visloc.evaluate_robot(np.array(truth), columns[:, :4], columns[:, 4])
    return found, poses


def _slam(run: Run) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    images = visloc.images(run.source, camera=run.camera, **_seed_of_source(run))
    slam = visloc.Slam(images.camera, seed=run.seed, parameters=dict(run.parameters) or None)
    states: dict[str, int] = {}
    stamps = []
    for at_s, image in islice(images, run.max_frames):
        state = slam.add_image(at_s, image).state
        states[state] = states.get(state, 0) + 1
        stamps.append(at_s)
    slam.finish()
    found = {"frames": len(stamps), "video_s": _duration(stamps), "states": states}
    found |= {"maps": len(slam.maps), "keyframes": slam.num_keyframes, "landmarks": len(slam.landmarks())}
    rows = sorted(((at_s, map, pose) for map in slam.maps for at_s, pose in slam.trajectory(map)), key=lambda row: row[0])
    poses = _poses([at_s for at_s, _, _ in rows], [pose for _, _, pose in rows])
    poses["map"] = np.array([map for _, map, _ in rows], dtype=int)
    is_largest = poses["map"] == (slam.maps or [0])[0]
    found["largest_map_poses"] = int(np.sum(is_largest))
    _compare(found, images.truth, poses["at_s"][is_largest], poses["world_from_camera"][is_largest])
    return found, poses


def _in_taught_map(run: Run) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    images = visloc.images(run.source, camera=run.camera, **_seed_of_source(run))
    taught = visloc.VisualMap.load(run.map or "")
    localizer = visloc.MapLocalizer(taught, images.camera, seed=run.seed, parameters=dict(run.parameters) or None)
    stamps, times, matrices, reliability = [], [], [], []
    for at_s, image in islice(images, run.max_frames):
        stamps.append(at_s)
        if estimate := localizer.step(at_s, image):
            times.append(at_s)
            matrices.append(estimate.world_from_camera)
            reliability.append(estimate.reliability)
    is_localized = np.array(reliability) >= 0.6
    found = {"frames": len(stamps), "video_s": _duration(stamps), "localized": int(np.sum(is_localized))}
    poses = _poses(times, matrices)
    _compare(found, images.truth, poses["at_s"], poses["world_from_camera"])
    return found, poses | {"reliability": np.array(reliability, dtype=float)}


def _poses(times: list, matrices: list) -> dict[str, np.ndarray]:
    return {"at_s": np.array(times, dtype=float), "world_from_camera": np.array(matrices, dtype=float).reshape(-1, 4, 4)}


def _compare(found: dict[str, Any], truth: Any, times: np.ndarray, matrices: np.ndarray) -> None:
    if not truth or len(times) < 3:
        return
    truth_times, truth_poses = (np.array(part) for part in zip(*truth))
    try:
        found["camera_error"] = visloc.evaluate_camera(truth_times, truth_poses, times, matrices)
    except visloc.VislocError:
        pass  # fewer than three poses of times that the truth has


def _duration(stamps: Any) -> float:
    return float(stamps[-1] - stamps[0]) if len(stamps) else 0.0
