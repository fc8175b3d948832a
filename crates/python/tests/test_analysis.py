"""From a set to a verdict, and what is shown of it."""

import json
import os
import signal
import threading
import time
from pathlib import Path

import pytest

import pushlab
import schemas

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def model(tilted):
    return pushlab.Model.nominal(tilted)


@pytest.fixture(scope="module")
def diagnosis(tilted, model):
    return pushlab.diagnose(tilted, model, progress=False)


@pytest.mark.parametrize("path, text", list(schemas.modules()))
def test_dataclasses_are_those_of_the_schemas(path, text):
    assert path.read_text(encoding="utf-8") == text, "run python tests/schemas.py"


def test_a_hidden_tilt_is_found(diagnosis):
    assert diagnosis.verdict == "identified"
    assert "table-tilt" in diagnosis.identified
    tilt = next(effect for effect in diagnosis.effects if effect.id == "table-tilt")
    assert {parameter.name for parameter in tilt.parameters} == {"ax", "ay"}
    assert all(parameter.low95 < parameter.high95 for parameter in tilt.parameters)
    assert diagnosis.error.after < diagnosis.error.before
    assert diagnosis.sentence in " ".join(str(diagnosis).split())
    assert "table-tilt" in diagnosis._repr_html_()


def test_a_diagnosis_is_kept_in_the_file_of_the_command_line(diagnosis, tmp_path):
    diagnosis.save(tmp_path / "diagnosis.json")
    assert pushlab.Diagnosis.read(tmp_path / "diagnosis.json") == diagnosis


def test_what_a_diagnosis_names_lowers_the_error(tilted, model, diagnosis):
    better = pushlab.add(model, diagnosis=diagnosis).model
    assert "table-tilt" in better.effects
    found = pushlab.compare(tilted, better, model, progress=False)
    assert found.part.pushes == "confirm"
    assert {change.name for change in found.against.changes} >= {"dx", "dy", "dtheta"}
    channel = found.channels[0]
    assert channel.name == "dx" and channel.unit == "m" and 0 < channel.rms < 1e-3
    page = pushlab.report(tilted, [model, better], diagnosis=diagnosis, progress=False)
    assert "<svg" in page.html and page._repr_html_().startswith("<iframe")


def test_pushes_are_suggested(tilted, model, diagnosis):
    found = pushlab.suggest(
        diagnosis, source=tilted, model=model, pushes=5, repeats=1, progress=False
    )
    assert len(found.pushes) == 5
    assert "suggested.csv" not in str(found)


def test_pushes_are_rolled_out_with_a_figure(tilted, model, tmp_path):
    found = pushlab.simulate(
        tilted, model, pushes=2, particles=200, output=tmp_path / "out", progress=False
    )
    assert (tmp_path / "out" / "poses.csv").exists()
    figures = found.figures
    assert len(figures) == 2 and figures[0]._repr_svg_().startswith("<svg")
    assert figures[0].text in found._repr_html_()


def test_a_table_in_memory_is_compared_like_its_file(pushes, nominal, steps, tmp_path):
    steps.write(tmp_path / "steps.parquet")
    steps_ = pushlab.read_steps(tmp_path / "steps.parquet", manifest=pushes.path / "dataset.toml")
    in_memory = pushlab.compare(steps, nominal, progress=False)
    assert in_memory.channels == pushlab.compare(steps_, nominal, progress=False).channels


def test_every_command_is_there(pushes):
    found = pushlab.command("effects", "list")
    assert found.document.schema == "pushlab.effects-list/1"
    assert "table-tilt" in str(found)
    with pytest.raises(pushlab.PushlabError, match="unrecognized subcommand"):
        pushlab.command("diagnoze")


def test_warnings_are_warnings_of_python_and_stand_in_the_result(pushes, nominal, tmp_path):
    text = nominal.path.read_text(encoding="utf-8")
    assert "pusher_radius_m = 0.00475" in text
    other = tmp_path / "other.toml"
    other.write_text(
        text.replace("pusher_radius_m = 0.00475", "pusher_radius_m = 0.01"), encoding="utf-8"
    )
    with pytest.warns(pushlab.PushlabWarning, match="was made for another rig"):
        found = pushlab.compare(pushes, other, progress=False)
    assert any("another rig" in warning for warning in found.warnings)


@pytest.fixture
def interruptible():
    """A shell that starts the tests in the background has them ignore interrupts."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_long_work_is_told_and_interrupted(tilted, model, interruptible):
    phases = []
    main = threading.main_thread().ident

    def stop(text, done, total):
        assert threading.get_ident() == main
        is_first = phases and all("recordings read" in phase for phase in phases)
        phases.append(text)
        if is_first and "recordings read" not in text:
            os.kill(os.getpid(), signal.SIGINT)

    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        pushlab.diagnose(tilted, model, progress=stop)
    interrupted = time.monotonic() - start
    assert any("recordings read" in phase for phase in phases)
    assert interrupted < 60


def test_what_a_progress_function_raises_ends_the_work(tilted, tmp_path):
    def refuse(text, done, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        pushlab.generate(tmp_path / "set", pushes=30, progress=refuse)
    time.sleep(0.3)
    assert not (tmp_path / "set" / "dataset.toml").exists()


def test_other_threads_go_on_meanwhile(tilted, model):
    done = threading.Event()
    counted = []

    def count():
        while not done.is_set():
            counted.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    pushlab.compare(tilted, model, progress=False)
    done.set()
    thread.join()
    assert len(counted) > 10


def test_documents_of_results_are_json(diagnosis):
    assert json.loads(json.dumps(diagnosis.document)) == diagnosis.document
