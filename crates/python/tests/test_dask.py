"""The examples for Dask, on a cluster of two workers of which one dies at its work."""

import csv
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import pushlab

pytest.importorskip("distributed")
from distributed import Client, LocalCluster, WorkerPlugin  # noqa: E402

EXAMPLES = Path(__file__).resolve().parents[1] / "examples" / "dask"


class DiesOnce(WorkerPlugin):
    """Writes down every command with a part, and dies in the midst of one, the first time."""

    def __init__(self, part, folder, sign=".*.part"):
        self.part, self.folder, self.sign = part, folder, sign

    def setup(self, worker):
        command = pushlab.command

        def noted(*words, **options):
            part = options.get("part")
            if part is not None:
                with open(self.folder / "begun", "a") as begun:
                    begun.write(f"{part} {os.getpid()}\n")
            if part == self.part and not (self.folder / "died").exists():
                options["progress"] = self.die
            return command(*words, **options)

        pushlab.command = noted

    def die(self, *_):
        if list(self.folder.rglob(self.sign)):
            (self.folder / "died").touch()
            os.kill(os.getpid(), signal.SIGKILL)


@pytest.fixture(scope="module")
def cluster():
    one_thread = {"threads_per_worker": 1, "env": {"RAYON_NUM_THREADS": "1"}}
    with LocalCluster(n_workers=2, dashboard_address=None, **one_thread) as cluster:
        yield cluster


def run(cluster, name, *words):
    """What an example prints, on the workers of the cluster."""
    typed = [sys.executable, EXAMPLES / name, *words, "--scheduler", cluster.scheduler_address]
    done = subprocess.run([str(word) for word in typed], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_parts_survive_a_worker_and_are_the_bytes_of_one_run(cluster, pushes, tmp_path):
    one, merged = tmp_path / "one.parquet", tmp_path / "merged.parquet"
    pushlab.command("ingest", pushes.path, step="4mm", output=one)
    kept = tmp_path / "merged.parquet.4-parts-of-4mm"
    kept.mkdir()
    pushlab.command("ingest", pushes.path, step="4mm", part="1/4", output=kept / "00001.parquet")
    with Client(cluster) as client:
        client.register_plugin(DiesOnce("2/4", tmp_path))
        printed = run(cluster, "ingest.py", pushes.path, "-o", merged, "--parts", 4, "--step", "4mm")
    assert "4 of 4 parts" in printed
    begun = [line.split() for line in (tmp_path / "begun").read_text().splitlines()]
    assert (tmp_path / "died").exists()
    assert sorted(part for part, _ in begun) == ["2/4", "2/4", "3/4", "4/4"]
    first, second = [worker for part, worker in begun if part == "2/4"]
    assert first != second
    assert merged.read_bytes() == one.read_bytes()
    assert not kept.exists()


def test_a_fit_survives_a_worker_and_is_that_of_one_process(cluster, tmp_path):
    pushes, model, fitted = tmp_path / "pushes", tmp_path / "model.toml", tmp_path / "fitted.toml"
    pushlab.generate(pushes, rig="quiet", pushes=12, format="csv", progress=False)
    pushlab.command("models", "init", pushes, output=model)
    with Client(cluster) as client:
        client.register_plugin(DiesOnce("2/3", tmp_path, ".*.lock"), name="dies in a fit")
        words = ["--model", model, "--free", "pusher-friction", "-o", fitted, "--parts", 3]
        printed = run(cluster, "fit.py", pushes, *words)
    assert (tmp_path / "died").exists()
    begun = [line.split() for line in (tmp_path / "begun").read_text().splitlines()]
    rounds = printed.count("standard errors²")
    # The sample, every part in every round, and the one that was lost once more.
    assert len(begun) == 1 + 3 * rounds + 1

    def part(number, **options):
        file = tmp_path / f"{number}.json"
        pushlab.command("statistics", pushes, part=f"{number}/3", output=file, force=True, **options)
        return file

    last, plain = part(1, model=model, free="pusher-friction"), tmp_path / "plain.toml"
    last = last.rename(tmp_path / "round-0.json")
    for number in range(1, rounds + 1):
        files = [part(number, round=last) for number in (2, 3, 1)]
        last = tmp_path / f"round-{number}.json"
        found = pushlab.command("merge", *files, output=last, fitted=plain, force=True).document
    assert plain.read_bytes() == fitted.read_bytes()
    assert found["fit"]["is_converged"]
    assert found["errors"]["channels"][0]["name"] == "dx"


def test_sets_are_diagnosed_once_and_those_that_cannot_be_say_why(cluster, tmp_path):
    tilted, empty, verdicts = tmp_path / "tilted", tmp_path / "empty", tmp_path / "verdicts"
    hidden = "table-tilt: x_m_s2=0.5"
    pushlab.generate(tilted, hidden=hidden, rig="quiet", pushes=16, format="csv", progress=False)
    empty.mkdir()
    run(cluster, "sets.py", tilted, empty, "-o", verdicts)
    made = (verdicts / "tilted.diagnosis.json").stat().st_mtime_ns
    printed = run(cluster, "sets.py", tilted, empty, "-o", verdicts)
    assert (verdicts / "tilted.diagnosis.json").stat().st_mtime_ns == made
    assert "tilted: identified table-tilt" in printed
    with open(verdicts / "verdicts.csv", newline="", encoding="utf-8") as file:
        refused, told = csv.DictReader(file)
    assert (refused["set"], refused["verdict"]) == ("empty", "refused")
    assert (told["set"], told["verdict"]) == ("tilted", "identified")
    assert "table-tilt" in told["effects"].split()
    assert float(told["error_after"]) < float(told["error_before"])


def test_a_sweep_counts_what_is_named(cluster):
    hidden = "table-tilt: x_m_s2={}, y_m_s2=0"
    options = ["--pushes", 16, "--seeds", 1, "--rig", "quiet"]
    printed = run(cluster, "sweep.py", hidden, 0.0001, 0.5, *options)
    assert [line.split() for line in printed.splitlines()] == [
        ["0.0001:", "named", "in", "0", "of", "1"],
        ["0.5:", "named", "in", "1", "of", "1"],
    ]
