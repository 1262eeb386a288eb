"""Examples and the notebook do what they say."""

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
TESTDATA = EXAMPLES.parents[1] / "testdata"


def test_a_bag_and_a_clip(tmp_path):
    for name, source, expected in (("localize_bag.py", "R1-excerpt.mcap", "90 frames"), ("slam_images.py", "desk-clip", "60 poses")):
        command = [sys.executable, EXAMPLES / name, TESTDATA / source]
        found = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert found.returncode == 0 and expected in found.stdout, found.stdout + found.stderr


def test_the_notebook_shows_pictures():
    nbformat = pytest.importorskip("nbformat", reason="needs pip install nbclient ipykernel matplotlib")
    nbclient = pytest.importorskip("nbclient", reason="needs pip install nbclient ipykernel matplotlib")
    pytest.importorskip("ipykernel", reason="needs pip install nbclient ipykernel matplotlib")
    notebook = nbformat.read(EXAMPLES / "where_is_the_robot.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(EXAMPLES)}}).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 2
    assert any("135 frames" in output.get("text", "") for output in outputs)
