"""Layouts for RViz and Foxglove show topics that there are."""

import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LAYOUTS = ROOT / "interop" / "ros2"


def named(text):
    return set(re.findall(r"/visloc/[a-z_]+|/initialpose|/diagnostics|/camera/[a-z_/]+", text))


def test_every_topic_of_the_layouts_is_published_or_documented():
    source = (ROOT / "crates" / "io" / "src" / "ros2" / "publish.rs").read_text()
    published = set(re.findall(r'advertise\(\s*"(/[a-z_/]+)"', source))
    documented = named((ROOT / "docs" / "ros2.md").read_text())
    for name in ("visloc.rviz", "foxglove.json"):
        topics = named((LAYOUTS / name).read_text())
        shown = {topic for topic in topics if topic.startswith("/visloc/")}
        assert len(shown) >= 5 and shown <= published, f"{name}: {shown - published}"
        assert topics - shown <= documented | {"/camera/image/compressed"}, name


def test_the_layouts_can_be_read():
    layout = json.loads((LAYOUTS / "foxglove.json").read_text())
    panels = []

    def walk(part):
        if isinstance(part, str):
            panels.append(part)
        else:
            walk(part["first"])
            walk(part["second"])

    walk(layout["layout"])
    assert sorted(panels) == sorted(layout["configById"])
    yaml = pytest.importorskip("yaml")
    rviz = yaml.safe_load((LAYOUTS / "visloc.rviz").read_text())["Visualization Manager"]
    assert all(display["Class"].startswith("rviz_default_plugins/") for display in rviz["Displays"])
