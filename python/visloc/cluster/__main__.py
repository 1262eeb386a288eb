"""``python -m visloc.cluster``."""

import argparse
import itertools
import json
import sys
from typing import Any

from .. import VislocError
from . import grid, run


def _seeds(text: str) -> list[int]:
    """``3``, ``1-5`` or ``1,2,7``."""
    seeds: list[int] = []
    for part in text.split(","):
        first, sign, last = part.partition("-")
        if not (first.isdecimal() and (last.isdecimal() or not sign)) or int(last or first) < int(first):
            raise argparse.ArgumentTypeError(f"expected N, N-M from the first to the last, or several of them with commas, found '{text}'")
        seeds += range(int(first), int(last or first) + 1)
    return seeds


def _setting(text: str) -> list[dict[str, Any]]:
    """``tracking.robust=true,false`` as one dict for each value."""
    name, sign, values = text.partition("=")
    if not sign or not values.strip():
        raise argparse.ArgumentTypeError(f"expected NAME=VALUE or NAME=VALUE,VALUE, found '{text}'")
    return [_nested(name.strip().split("."), value) for value in _values(values)]


def _values(text: str) -> list[Any]:
    """Numbers, truth values and lists of them as JSON has them, else words."""
    try:
        return json.loads(f"[{text}]")
    except ValueError:
        return [_value(part.strip()) for part in text.split(",")]


def _value(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return text


def _nested(names: list[str], value: Any) -> dict[str, Any]:
    return {names[0]: _nested(names[1:], value) if names[1:] else value}


def _merged(parts: tuple[dict[str, Any], ...]) -> dict[str, Any]:
    out: dict[str, Any] = {}
    for part in parts:
        for name, value in part.items():
            out[name] = _merged((out[name], value)) if isinstance(value, dict) and name in out else value
    return out


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("python -m visloc.cluster", description="Recordings x seeds x parameters, on Ray.")
    parser.add_argument("command", choices=["localize", "slam"])
    parser.add_argument("source", nargs="+", help="recording, folder, pattern ('*.mcap') or address (s3://...)")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder or address for results; what is there is not done again")
    parser.add_argument("--map", metavar="MAP", help="name or file; a .vmap too")
    parser.add_argument("--camera", metavar="FILE", help="calibration, over what the source says")
    parser.add_argument("--algorithm", action="append", metavar="NAME", help="several times: each of them [evolutionary]")
    parser.add_argument("--seeds", type=_seeds, default=[1], metavar="N-M", help="for instance 1-5, or 1,3 [1]")
    parser.add_argument("--set", action="append", type=_setting, default=[], metavar="NAME=V,V", help="a parameter, each of its values")
    parser.add_argument("--max-frames", type=int, metavar="N")
    parser.add_argument("--address", metavar="ADDRESS", help="of a cluster: auto, HOST:6379, ray://HOST:10001 [this machine]")
    parser.add_argument("--workers", type=int, metavar="N", help="runs at a time [one for each core]")
    parser.add_argument("--dry-run", action="store_true", help="say what would be run")
    return parser


def main() -> int:
    given = _arguments().parse_args()
    try:
        work = grid(
            *given.source,
            command=given.command,
            seeds=given.seeds,
            parameters=[_merged(parts) for parts in itertools.product(*given.set)],
            algorithms=given.algorithm or ["evolutionary"],
            map=given.map,
            camera=given.camera,
            max_frames=given.max_frames,
        )
        if given.dry_run:
            print(*(one.title for one in work), sep="\n")
            return 0
        summary = run(work, given.out, address=given.address, workers=given.workers)
    except (VislocError, ImportError, OSError) as reason:
        print(f"error: {reason}", file=sys.stderr)
        return 2
    print(summary)
    return 1 if summary.failed else 0


if __name__ == "__main__":
    sys.exit(main())
