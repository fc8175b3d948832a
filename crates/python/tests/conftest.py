"""Recordings and models that several tests share."""

from pathlib import Path

import pytest

import pushlab

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def pushes():
    """The recordings of the repository."""
    return pushlab.RecordingSet(ROOT / "fixtures" / "pushes")


@pytest.fixture(scope="session")
def steps(pushes):
    """Their steps."""
    return pushes.ingest(progress=False)


@pytest.fixture(scope="session")
def nominal(pushes):
    """Their nominal model."""
    return pushlab.Model.nominal(pushes)


@pytest.fixture(scope="session")
def tilted(tmp_path_factory):
    """A quiet rig on a tilted table."""
    folder = tmp_path_factory.mktemp("tilted") / "set"
    options = {"hidden": "table-tilt", "rig": "quiet", "pushes": 40, "format": "csv"}
    return pushlab.generate(folder, **options, progress=False)
