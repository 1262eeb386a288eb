"""How does the number of particles change the error? Several seeds, on all cores. With pandas and matplotlib it becomes a picture."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np

import visloc


def run(num_particles, seed, num_frames=600):
    frames = visloc.frames("sim:robocup", seed=seed)
    localizer = visloc.Localizer(frames.map, "mce", seed=seed, parameters={"num_particles": num_particles})
    rows = []
    for frame, _ in zip(frames, range(num_frames)):
        estimate = localizer.step(frame)
        rows.append((frame.at_s, estimate.x_m, estimate.y_m, estimate.yaw_rad, estimate.reliability, *frame.truth))
    rows = np.array(rows)
    result = visloc.evaluate_robot(rows[:, [0, 5, 6, 7]], rows[:, :4], rows[:, 4])
    return {
        "num_particles": num_particles,
        "seed": seed,
        "localized": result["localized_share"],
        "error_m": result["tracking_position_error_m"]["median"],
    }


if __name__ == "__main__":
    cells = [(number, seed) for number in (100, 200, 500) for seed in range(1, 6)]
    # Steps run outside of the interpreter's lock, so threads are enough.
    with ThreadPoolExecutor() as pool:
        rows = list(pool.map(lambda cell: run(*cell), cells))
    try:
        import pandas as pd
    except ImportError:
        print(*rows, sep="\n")
    else:
        table = pd.DataFrame(rows)
        print(table.groupby("num_particles")[["localized", "error_m"]].median())
        table.boxplot("error_m", by="num_particles").figure.savefig("study.png")
