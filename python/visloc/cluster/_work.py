"""What is to be run: recordings, seeds, parameters."""

import hashlib
import itertools
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import PurePosixPath
from typing import Any

from .. import Camera, Localizer, Map, Slam, VislocError, __version__, map_names

_BAGS = (".mcap", ".db3", ".bag")


@dataclass(frozen=True)
class Run:
    """One recording, followed once. Everything that its numbers depend on."""

    command: str
    """``localize`` (on a known map, or in a ``.vmap``) or ``slam``."""
    source: str
    """What the program takes, with paths that every worker sees; or an address of fsspec (``s3://...``)."""
    seed: int = 1
    map: str | None = None
    """Name or file, for ``localize``; without it the one that the source knows."""
    algorithm: str = "evolutionary"
    """On a known map: one of ``visloc.algorithms()``."""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """Of the algorithm or of SLAM; what is left out keeps its default."""
    camera: str | None = None
    """A calibration, over what the source itself says."""
    max_frames: int | None = None

    def __post_init__(self) -> None:
        if self.command not in ("localize", "slam"):
            raise VislocError(f"command: expected localize or slam, found {self.command!r}")
        if self.max_frames is not None and self.max_frames < 1:
            raise VislocError(f"max_frames: expected at least 1, found {self.max_frames}")

    def to_json(self) -> str:
        """The run as text; equal runs have equal text."""
        return json.dumps(asdict(self), sort_keys=True)

    @staticmethod
    def from_json(text: str) -> "Run":
        return Run(**json.loads(text))

    @property
    def key(self) -> str:
        """Names the result: 20 characters that tell this run, by this version of visloc, from all others."""
        return hashlib.sha256(f"{__version__} {self.to_json()}".encode()).hexdigest()[:20]

    @property
    def title(self) -> str:
        """For people: ``localize R1.mcap seed 3``."""
        name = self.source if ":" in self.source and "://" not in self.source else PurePosixPath(self.source).name
        changed = "".join(f" {name}={value}" for name, value in _flat(self.parameters))
        return f"{self.command} {name} seed {self.seed}{changed}"


def _flat(parameters: Mapping[str, Any], prefix: str = "") -> Iterable[tuple[str, Any]]:
    for name, value in parameters.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def recordings(*sources: str | os.PathLike[str]) -> list[str]:
    """Each source's recordings, sorted: what a pattern (``*.mcap``) matches, all bags below a folder; a folder without any is one
    recording (images, a dataset), and so is ``sim:NAME``. Sources are paths or addresses of fsspec (``s3://...``).

    :raises VislocError: if there is nothing.
    """
    found = list(dict.fromkeys(one for source in sources for one in _recordings_of(os.fspath(source))))
    if not found:
        raise VislocError("expected at least one recording, found none")
    return found


def _recordings_of(source: str) -> list[str]:
    from ._store import filesystem

    if ":" in source and "://" not in source and not os.path.exists(source):
        return [source]  # sim:NAME, tum:DIR: the program's own words
    fs, path = filesystem(source)
    is_remote = "://" in source
    paths = sorted(fs.glob(path)) if any(sign in path for sign in "*?[") else [path] if fs.exists(path) else []
    if not paths:
        raise VislocError(f"{source}: expected a recording, a folder or a pattern that matches some, found nothing there")
    bags = (bag for one in paths for bag in (_bags_below(fs, one) if fs.isdir(one) else [one]))
    return [fs.unstrip_protocol(bag) if is_remote else bag for bag in bags]


def _bags_below(fs: Any, folder: str) -> list[str]:
    files = set(fs.find(folder))
    bags = set()
    for file in files:
        if file.endswith(_BAGS):
            parent = file.rsplit("/", 1)[0]
            bags.add(parent if f"{parent}/metadata.yaml" in files else file)
    return sorted(bags) or [folder]


def grid(
    *sources: str | os.PathLike[str],
    command: str = "localize",
    seeds: Iterable[int] = (1,),
    parameters: Iterable[Mapping[str, Any]] = ({},),
    algorithms: Iterable[str] = ("evolutionary",),
    map: str | os.PathLike[str] | None = None,
    camera: str | os.PathLike[str] | None = None,
    max_frames: int | None = None,
) -> list[Run]:
    """All recordings of ``sources`` with all seeds, algorithms and parameters.

    :raises VislocError: if a source has no recording, an algorithm does not take the parameters, or something is given that would not
        be used.
    """
    parameters, algorithms = list(parameters), list(algorithms)
    if command == "slam" and map is not None:
        raise VislocError(f"map: expected none with slam, which makes its own, found {map}")
    if (command == "slam" or str(map).endswith(".vmap")) and algorithms != ["evolutionary"]:
        raise VislocError(f"algorithms: they are for localize on a known map, found {', '.join(algorithms)}")
    for algorithm, changed in itertools.product(algorithms, parameters):
        _check(command, map, algorithm, changed)
    cells = itertools.product(recordings(*sources), algorithms, parameters, seeds)
    map, camera = _seen_by_workers(map), _seen_by_workers(camera)
    return [
        Run(command, source, seed, map, algorithm, dict(changed), camera, max_frames)
        for source, algorithm, changed, seed in cells
    ]


def _check(command: str, map: str | os.PathLike[str] | None, algorithm: str, parameters: Mapping[str, Any]) -> None:
    """A wrong name is said before anything runs."""
    if command == "slam" or str(map).endswith(".vmap"):
        Slam(Camera((640, 480), (500.0, 500.0), (319.5, 239.5)), parameters=dict(parameters) or None)
    else:
        # A file may be one that workers alone see; a name is known everywhere.
        is_name = map is not None and not any(sign in str(map) for sign in "./\\")
        Localizer(Map(str(map) if is_name else map_names()[0]), algorithm, parameters=dict(parameters) or None)


def _seen_by_workers(file: str | os.PathLike[str] | None) -> str | None:
    """Workers run in folders of their own."""
    if file is None or "://" in str(file) or not os.path.exists(file):
        return None if file is None else str(file)
    return os.path.abspath(file)
