"""Compares two JSON files of `visloc localize --json`: errors may differ by a tenth, or by a millimeter and 0.02 degrees. Where images were
lost on the way, statistics of fewer images may be smaller by more than that.

    python compare.py BAG.json LIVE.json
"""

import json
import sys

with open(sys.argv[1]) as bag, open(sys.argv[2]) as live:
    bag, live = json.load(bag), json.load(live)
wrong = False
for key, least in (("position_error_m", 0.001), ("heading_error_deg", 0.02)):
    for statistic in ("mean", "median", "p95"):
        a, b = bag[key][statistic], live[key][statistic]
        worse = b - a if live["frames"] < bag["frames"] else abs(b - a)
        is_wrong = worse > max(0.1 * a, least)
        wrong |= is_wrong
        print(f"{key} {statistic}: bag {a:.4f}, live {b:.4f}{'  DIFFERS' if is_wrong else ''}")
overhead = live["live"]["overhead_ms"]
print(f"{live['frames']} of {bag['frames']} frames; beside the algorithm {overhead['median']:.2f} ms (median), {overhead['p99']:.2f} (99 %)")
sys.exit("the errors differ" if wrong else 0)
