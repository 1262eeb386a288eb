"""Runs on Ray against the same runs without, and against what happens on clusters: workers that die, files that are bad."""

import os
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import visloc

pytest.importorskip("fsspec", reason="visloc.cluster is optional: pip install visloc[cluster]")
parquet = pytest.importorskip("pyarrow.parquet", reason="visloc.cluster is optional: pip install visloc[cluster]")
from visloc import cluster  # noqa: E402

TESTDATA = Path(__file__).parents[2] / "testdata"
R1 = TESTDATA / "R1-excerpt.mcap"
FIELD = "robocup-spl-2010"
TIMES = ["wall_s", "cpu_s", "host"]


@pytest.fixture(scope="module")
def ray():
    ray = pytest.importorskip("ray", reason="visloc.cluster runs on Ray: pip install visloc[cluster]")
    ray.init(num_cpus=2, log_to_driver=False, include_dashboard=False)
    yield ray
    ray.shutdown()


def without_times(table):
    return table.drop_columns(TIMES).to_pylist()


def test_a_grid_has_every_recording_with_every_seed_and_parameter():
    work = cluster.grid(R1, "sim:robocup", map=FIELD, seeds=[1, 2], parameters=[{"num_exploiters": n} for n in (40, 80)])
    assert len(work) == len({run.key for run in work}) == 8
    assert {run.source for run in work} == {str(R1), "sim:robocup"}
    assert cluster.Run.from_json(work[3].to_json()) == work[3]
    with pytest.raises(visloc.VislocError, match="num_exploiters"):
        cluster.grid(R1, map=FIELD, parameters=[{"num_exploiter": 3}])
    with pytest.raises(visloc.VislocError, match="map robocup: "):
        cluster.grid(R1, map="robocup")
    with pytest.raises(visloc.VislocError, match="nothing there"):
        cluster.grid("no/such/*.mcap", map=FIELD)
    with pytest.raises(visloc.VislocError, match="localize or slam"):
        cluster.Run("fly", str(R1))
    with pytest.raises(visloc.VislocError, match="map: expected none with slam"):
        cluster.grid("sim:room", command="slam", map="room.vmap")
    with pytest.raises(visloc.VislocError, match="algorithms: they are for localize on a known map, found mce"):
        cluster.grid("sim:room", command="slam", algorithms=["mce"])


def test_words_of_a_shell(monkeypatch, capsys):
    from visloc.cluster.__main__ import main

    def said(*words):
        monkeypatch.setattr("sys.argv", ["visloc.cluster", "localize", "sim:robocup", "--map", FIELD, "--out", "out", "--dry-run", *words])
        try:
            code = main()
        except SystemExit as end:
            code = end.code
        return code, "".join(capsys.readouterr()).splitlines()

    code, titles = said("--seeds", "1-2,7", "--set", "motion.correction=[1,1,1],[0.9,1,1]")
    assert code == 0 and len(titles) == 6 and titles[0].endswith("seed 1 motion.correction=[1, 1, 1]")
    for words in (["--seeds", "5-1"], ["--seeds", "a"], ["--set", "num_exploiters"], ["--set", "num_exploiters="]):
        code, lines = said(*words)
        assert code == 2 and f"argument {words[0]}: expected" in lines[-1], lines


def test_recordings_are_found_in_folders_patterns_and_addresses(tmp_path):
    for name in ("b.mcap", "a.db3", "note.txt", "rosbag/part_0.mcap", "rosbag/part_1.mcap", "rosbag/metadata.yaml", "images/1.png"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    folder = str(tmp_path)
    assert cluster.recordings(tmp_path) == [f"{folder}/a.db3", f"{folder}/b.mcap", f"{folder}/rosbag"]
    assert cluster.recordings(f"{folder}/*.mcap") == [f"{folder}/b.mcap"]
    assert cluster.recordings(f"{folder}/images", "sim:room") == [f"{folder}/images", "sim:room"]
    assert cluster.recordings(f"file://{folder}/*.db3") == [f"file://{folder}/a.db3"]


def test_a_run_is_what_the_classes_do():
    outcome = cluster.execute(cluster.Run("localize", str(R1), seed=3, map=FIELD))
    localizer = visloc.Localizer(visloc.Map(FIELD), seed=3)
    ours = [(frame.at_s, (estimate := localizer.step(frame)).x_m, estimate.yaw_rad) for frame in visloc.frames(str(R1))]
    assert np.array_equal(np.array(ours), np.column_stack([outcome.poses[name] for name in ("at_s", "x_m", "yaw_rad")]))
    assert outcome.row["frames"] == len(ours) and outcome.row["tracking_position_error_m_median"] < 0.05


def test_slam_and_cameras_in_its_map_run_too(tmp_path):
    clip = str(TESTDATA / "desk-clip")
    row = cluster.execute(cluster.Run("slam", clip, seed=2)).row
    assert row["frames"] == 60 and row["states_tracking"] > 30 and row["camera_error_pairs"] == row["largest_map_poses"] > 30
    images = visloc.images(clip)
    slam = visloc.Slam(images.camera, seed=2)
    for at_s, image in images:
        slam.add_image(at_s, image)
    slam.save(tmp_path / "desk.vmap")
    outcome = cluster.execute(cluster.Run("localize", clip, map=str(tmp_path / "desk.vmap"), max_frames=20))
    assert outcome.row["localized"] > 15 and outcome.poses["world_from_camera"].shape[1:] == (4, 4)


def test_recordings_and_results_may_be_elsewhere(tmp_path):
    import fsspec

    elsewhere = fsspec.filesystem("memory")
    elsewhere.pipe_file("/bags/R1.mcap", R1.read_bytes())
    [run] = cluster.grid("memory://bags/*.mcap", map=FIELD, max_frames=20)
    here = cluster.execute(cluster.Run("localize", str(R1), map=FIELD, max_frames=20))
    outcome = cluster.execute(run)
    assert np.array_equal(outcome.poses["x_m"], here.poses["x_m"])
    from visloc.cluster._store import Store

    Store("memory://results").keep(run, outcome)
    assert cluster.results("memory://results")["source"].to_pylist() == [run.source]


def test_numbers_are_those_without_ray_and_what_fails_is_kept_apart(ray, tmp_path):
    bad = tmp_path / "bad.mcap"
    bad.write_bytes(b"no bag")
    work = cluster.grid(R1, bad, map=FIELD, seeds=[1, 2], max_frames=40)
    summary = cluster.run(work, tmp_path / "out")
    assert (summary.done, summary.there, len(summary.failed)) == (2, 0, 2)
    assert all("bad.mcap" in entry["reason"] for entry in cluster.failures(tmp_path / "out"))
    table = parquet.read_table(summary.results)
    for run, row in zip(work, without_times(table)):
        alone = cluster.execute(run)
        assert row == {name: value for name, value in alone.row.items() if name not in TIMES}
        poses = parquet.read_table(tmp_path / "out" / "runs" / f"{run.key}.parquet")
        assert np.array_equal(poses["x_m"].to_numpy(), alone.poses["x_m"])


def test_the_same_call_again_does_only_what_is_missing(ray, tmp_path):
    out = tmp_path / "out"
    cluster.run(cluster.grid(R1, map=FIELD, seeds=[1, 2], max_frames=20), out)
    before = {file: file.stat().st_mtime_ns for file in (out / "runs").iterdir()}
    damaged, kept = sorted(before)
    damaged.write_bytes(damaged.read_bytes()[:100])
    assert cluster.results(out).num_rows == 1  # what is damaged is set aside
    summary = cluster.run(cluster.grid(R1, map=FIELD, seeds=[1, 2, 3], max_frames=20), out)
    assert (summary.done, summary.there) == (2, 1)
    assert kept.stat().st_mtime_ns == before[kept]
    assert sorted(cluster.results(out)["seed"].to_pylist()) == [1, 2, 3]


def test_a_worker_that_is_killed_loses_and_doubles_nothing(ray, tmp_path):
    work = cluster.grid("sim:robocup", map=FIELD, seeds=range(7001, 7007), max_frames=150)
    killed = []

    def kill_one():
        while not killed:
            for process in Path("/proc").glob("[0-9]*"):
                try:
                    name = (process / "cmdline").read_bytes()
                    if name.startswith(b"ray::localize sim:robocup seed 700"):
                        os.kill(int(process.name), signal.SIGKILL)
                        killed.append(process.name)
                        return
                except OSError:
                    pass
            time.sleep(0.02)

    thread = threading.Thread(target=kill_one, daemon=True)
    thread.start()
    summary = cluster.run(work, tmp_path / "out")
    assert killed and (summary.done, summary.failed) == (6, [])
    rows = without_times(cluster.results(tmp_path / "out"))
    assert [row["seed"] for row in rows] == list(range(7001, 7007))
    assert [row["frames"] for row in rows] == [150] * 6
    assert len(list((tmp_path / "out" / "runs").iterdir())) == 6


def test_a_run_that_takes_its_worker_down_is_given_up(ray, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster._engine, "_perform", _die)
    summary = cluster.run(cluster.grid(R1, map=FIELD), tmp_path / "out", tries=2)
    assert summary.done == 0 and "its worker ended 2 times" in summary.failed[0][1]


def _die(*_):
    os._exit(1)
