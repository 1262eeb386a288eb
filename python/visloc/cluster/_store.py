"""Results in a folder, or at an address of fsspec.

``runs/KEY.parquet`` is one run: its poses, and in the metadata ``visloc.result`` its row. It is written beside and then named, so what has
the name is whole, and a run that is done twice (a worker died after it had written) is there once. ``failures/KEY.json`` is a run that
failed. ``results.parquet`` has one row for each run of ``runs/``.
"""

import json
import os
import uuid
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

from ._work import Run

if TYPE_CHECKING:
    import pyarrow

    from ._execute import Outcome


def filesystem(address: str | os.PathLike[str]) -> tuple[Any, str]:
    """The file system of a path or address, and the path in it."""
    try:
        from fsspec.core import url_to_fs
    except ImportError as reason:
        raise ImportError("visloc.cluster needs fsspec: pip install 'visloc[cluster]'") from reason
    return url_to_fs(os.fspath(address))


def results(out: str | os.PathLike[str]) -> "pyarrow.Table":
    """One row a run that is done, sorted by source, algorithm, parameters, seed."""
    return Store(out).rows()


def failures(out: str | os.PathLike[str]) -> list[dict[str, Any]]:
    """Runs that failed last time: ``run``, ``reason``, ``trace``."""
    store = Store(out)
    return [json.loads(store.read("failures", key)) for key in sorted(store.keys("failures"))]


class Store:
    """Results of runs."""

    def __init__(self, out: str | os.PathLike[str]) -> None:
        self.address = os.fspath(out) if "://" in os.fspath(out) else os.path.abspath(out)
        self.fs, self.root = filesystem(self.address)
        self.fs.invalidate_cache()

    def keys(self, kind: str) -> set[str]:
        """Keys of what is there of ``runs`` or ``failures``."""
        folder = f"{self.root}/{kind}"
        if not self.fs.exists(folder):
            return set()
        names = (path.rsplit("/", 1)[-1] for path in self.fs.ls(folder, detail=False))
        return {name.partition(".")[0] for name in names if name.endswith(_suffix(kind))}

    def read(self, kind: str, key: str) -> bytes:
        return self.fs.cat_file(self._path(kind, key))

    def keep(self, run: Run, outcome: "Outcome") -> None:
        """Writes a run's result, and forgets that it failed before."""
        import pyarrow
        import pyarrow.parquet

        columns = {
            name: values if values.ndim == 1 else pyarrow.FixedSizeListArray.from_arrays(values.ravel(), values[0].size if len(values) else 16)
            for name, values in outcome.poses.items()
        }
        table = pyarrow.table(columns).replace_schema_metadata({"visloc.result": json.dumps(outcome.row)})
        sink = pyarrow.BufferOutputStream()
        pyarrow.parquet.write_table(table, sink)
        self._write(self._path("runs", run.key), sink.getvalue().to_pybytes())
        self._forget(self._path("failures", run.key))

    def keep_failure(self, run: Run, reason: str, trace: str = "") -> None:
        """Writes why a run has no result."""
        entry = {"run": json.loads(run.to_json()), "reason": reason, "trace": trace}
        self._write(self._path("failures", run.key), json.dumps(entry, indent=1).encode())

    def rows(self) -> "pyarrow.Table":
        """All rows; results that cannot be read are set aside as ``.damaged``, so that their runs are done again."""
        import pyarrow

        with ThreadPoolExecutor(16) as pool:
            found = [row for row in pool.map(self._row, sorted(self.keys("runs"))) if row]
        found.sort(key=lambda row: (row["source"], row["algorithm"], row["parameters"], row["seed"], row["key"]))
        names = list(dict.fromkeys(name for row in found for name in row))
        return pyarrow.table({name: pyarrow.array([row.get(name) for row in found]) for name in names})

    def gather(self) -> str:
        """Writes ``results.parquet``, and says where."""
        import pyarrow
        import pyarrow.parquet

        sink = pyarrow.BufferOutputStream()
        pyarrow.parquet.write_table(self.rows(), sink)
        path = f"{self.root}/results.parquet"
        self._write(path, sink.getvalue().to_pybytes())
        return self.fs.unstrip_protocol(path) if "://" in self.address else path

    def _row(self, key: str) -> dict[str, Any] | None:
        import pyarrow.parquet

        path = self._path("runs", key)
        try:
            with self.fs.open(path) as file:
                return json.loads(pyarrow.parquet.read_schema(file).metadata[b"visloc.result"])
        except (pyarrow.ArrowInvalid, KeyError, TypeError, ValueError):
            self.fs.mv(path, f"{path}.damaged")
            return None

    def _path(self, kind: str, key: str) -> str:
        return f"{self.root}/{kind}/{key}{_suffix(kind)}"

    def _write(self, path: str, content: bytes) -> None:
        folder, name = path.rsplit("/", 1)
        self.fs.makedirs(folder, exist_ok=True)
        partial = f"{folder}/.{name}.{uuid.uuid4().hex}"
        self.fs.pipe_file(partial, content)
        self.fs.mv(partial, path)

    def _forget(self, path: str) -> None:
        try:
            self.fs.rm_file(path)
        except FileNotFoundError:
            pass


def _suffix(kind: str) -> str:
    return ".parquet" if kind == "runs" else ".json"
