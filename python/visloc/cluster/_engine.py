"""Runs on Ray."""

import logging
import os
import sys
import time
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from ._execute import execute
from ._store import Store
from ._work import Run

# Runs that wait at Ray: enough for an autoscaler to see what is needed, few enough for any number of runs in all.
_AT_RAY = 2000


@dataclass(frozen=True)
class Summary:
    """What became of the work."""

    done: int
    there: int
    """Runs whose result was there before."""
    failed: list[tuple[Run, str]]
    """Runs without a result, with the reason; also in ``failures/``."""
    wall_s: float
    results: str
    """The file with one row for each run."""

    def __str__(self) -> str:
        return f"{self.done} runs done in {self.wall_s:.1f} s, {self.there} were there, {len(self.failed)} failed: {self.results}"


def run(
    work: Iterable[Run],
    out: str | os.PathLike[str],
    *,
    address: str | None = None,
    workers: int | None = None,
    tries: int = 4,
    runtime_env: dict[str, Any] | None = None,
    progress: Callable[[str], None] | None = None,
) -> Summary:
    """Does what of the work has no result in ``out`` yet. Stopped at any time, the same call goes on.

    :param out: a folder that all workers see, or an address of fsspec.
    :param address: of a cluster (``auto``, ``HOST:6379``, ``ray://HOST:10001``); without it, this machine (or what Ray runs already).
    :param workers: runs at a time; without it, one for each core.
    :param tries: times that a run may take its worker down (memory, a machine that leaves) before it counts as failed.
    :param runtime_env: what workers need, as Ray has it: ``{"pip": ["visloc[cluster]"]}``.
    :param progress: is told a sentence every few seconds; without it, it goes to standard error.
    :raises ImportError: without Ray.
    """
    store = Store(out)
    wanted = {one.key: one for one in work}
    there = wanted.keys() & store.keys("runs")
    waiting = [one for key, one in wanted.items() if key not in there]
    begin = time.monotonic()
    failed: list[tuple[Run, str]] = []
    if waiting:
        say = progress or (lambda sentence: print(sentence, file=sys.stderr, flush=True))
        with _ray(address, workers) as (ray, page):
            say(f"{len(waiting)} runs, {len(there)} are there{page}")
            said_at = runs_begin = time.monotonic()
            try:
                for number, (one, reason) in enumerate(_outcomes(ray, waiting, store, workers, tries, runtime_env), 1):
                    if reason:
                        failed.append((one, reason))
                        say(f"failed: {one.title}: {reason}")
                    now = time.monotonic()
                    if now - said_at > 5.0 or number == len(waiting):
                        said_at, left_s = now, (now - runs_begin) / number * (len(waiting) - number)
                        say(f"{number} of {len(waiting)} runs, {len(failed)} failed, {now - runs_begin:.0f} s, about {left_s:.0f} s to go")
            except BaseException:
                store.gather()
                raise
    path = store.gather()
    return Summary(len(waiting) - len(failed), len(there), failed, time.monotonic() - begin, path)


def _outcomes(
    ray: Any, waiting: list[Run], store: Store, workers: int | None, tries: int, runtime_env: dict[str, Any] | None
) -> Iterator[tuple[Run, str | None]]:
    """Each run with the reason why it failed, as they end."""
    environment = {**(runtime_env or {})}
    environment["env_vars"] = {"RAYON_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", **environment.get("env_vars", {})}
    task, options = ray.remote(_perform), {"num_cpus": 1, "max_retries": tries - 1, "runtime_env": environment}
    at_ray: dict[Any, Run] = {}
    to_do = iter(waiting)
    try:
        while True:
            for one in to_do:
                at_ray[task.options(name=one.title, **options).remote(one.to_json(), store.address)] = one
                if len(at_ray) >= (workers or _AT_RAY):
                    break
            if not at_ray:
                return
            for finished in ray.wait(list(at_ray), num_returns=1)[0]:
                one = at_ray.pop(finished)
                try:
                    yield one, ray.get(finished)
                except ray.exceptions.RayError as reason:
                    sentence = f"its worker ended {tries} times: {str(reason).strip().splitlines()[0]}"
                    store.keep_failure(one, sentence, str(reason))
                    yield one, sentence
    finally:
        for left in at_ray:
            ray.cancel(left, force=True)


def _perform(text: str, out: str) -> str | None:
    """On a worker: one run, its result or why it has none."""
    one, store = Run.from_json(text), Store(out)
    try:
        store.keep(one, execute(one))
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException as reason:  # a panic of the library is no Exception
        sentence = f"{type(reason).__name__}: {reason}"
        store.keep_failure(one, sentence, traceback.format_exc())
        return sentence
    return None


@contextmanager
def _ray(address: str | None, workers: int | None) -> Iterator[tuple[Any, str]]:
    """Ray, and where its page is."""
    try:
        import ray
    except ImportError as reason:
        raise ImportError("visloc.cluster needs Ray: pip install 'visloc[cluster]'") from reason
    if ray.is_initialized():
        yield ray, ""
        return
    is_here = address is None and "RAY_ADDRESS" not in os.environ
    cores = workers if is_here else None
    context = ray.init(address, num_cpus=cores, log_to_driver=False, logging_level=logging.WARNING)
    try:
        url = context.dashboard_url
        yield ray, f"; Ray's page: http://{url}" if url else ""
    finally:
        ray.shutdown()
