"""Many runs on many machines: recordings x seeds x parameters, on Ray.

::

    from visloc import cluster

    work = cluster.grid("s3://robots/2026/*.mcap", map="robocup-spl-2010", seeds=range(1, 6),
                        parameters=[{"num_particles": n} for n in (100, 200, 500)])
    summary = cluster.run(work, out="results")           # this machine; address="auto" for a cluster
    print(summary, cluster.results("results"))           # a pyarrow.Table, one row a run

Give the same call again, and only what is not there yet is done. Needs ``pip install visloc[cluster]``. From a shell:
``python -m visloc.cluster localize R1.mcap --map robocup-spl-2010 --seeds 1-5 --out results``.

A run goes through the wheel's own classes in a process of Ray, on one thread: workers need no program beside the wheel, what Ray
knows of a process (memory, exit, retries) is known of a run, and the numbers are those of the same run without Ray (``execute``).
"""

from ._engine import Summary, run
from ._execute import Outcome, execute
from ._store import failures, results
from ._work import Run, grid, recordings

__all__ = ["Outcome", "Run", "Summary", "execute", "failures", "grid", "recordings", "results", "run"]
