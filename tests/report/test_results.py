"""What `calibrate`, `diagnose` and `compare` give in Python."""

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import jsonschema
import pytest

import robolaser
from robolaser.data.saved_result import SavedResult
from robolaser.errors import OutputError, UsageError
from robolaser.results import VEGA_LITE, Result
from robolaser.simulation import simulate

SCHEMAS = Path(robolaser.__file__).parent / "schemas"


def keeps_its_contract(result: Result, kind: str, folder: Path) -> None:
    said = result.to_dict()
    jsonschema.validate(said, json.loads((SCHEMAS / f"{kind}.schema.json").read_text()))
    assert len(str(result).splitlines()) > 2
    assert str(result).splitlines()[0].partition(":")[0] in result._repr_html_()
    assert ("<table>" in result._repr_html_()) == (not isinstance(result, SavedResult))
    assert len(result.to_frame().columns) > 3
    result.save(folder / kind)
    assert json.loads((folder / kind / f"{kind}.json").read_text()) == said
    assert (folder / kind / "report.html").exists()
    result.report(folder / "alone.html")
    assert (folder / "alone.html").read_text().lower().startswith("<!doctype html>")
    assert repr(result) == str(result).rstrip("\n")
    if isinstance(result, SavedResult):
        with pytest.raises(UsageError, match=r"its report\.html shows them"):
            result.plot()
    else:
        draws_its_charts(result)
    result.save(folder / kind)  # its own earlier result
    (folder / "foreign").mkdir(exist_ok=True)
    (folder / "foreign" / "report.html").write_text("mine")
    with pytest.raises(OutputError):
        result.save(folder / "foreign")


def draws_its_charts(result: Result) -> None:
    """All of them, or those of a title, in colours that need no style sheet."""
    every = result.plot()
    assert every.html.count("<svg") == len(every.titles) > 1
    shown = every._repr_mimebundle_()
    assert "var(" not in every._repr_html_()
    assert "text/html" not in shown  # which JupyterLab prefers to Vega-Lite
    assert len(ElementTree.fromstring(shown["image/svg+xml"]).findall("{*}svg")) == len(every.titles)
    assert [one["title"]["text"] for one in shown[VEGA_LITE]["vconcat"]] == list(every.titles)
    vega = pytest.importorskip("vl_convert")
    drawn = vega.vegalite_to_svg(shown[VEGA_LITE], vl_version="5.20")
    assert drawn.count("<path") > 10
    assert not re.search(r"NaN|var\(", drawn)
    assert result.plot(every.titles[-1].upper()).titles == every.titles[-1:]
    with pytest.raises(UsageError, match=f"There are: {re.escape(every.titles[0])}"):
        result.plot("nothere")


def test_results_print_show_tabulate_save_and_are_read_back(tmp_path):
    dataset = simulate(robolaser.find_robot("scorbot_er7"), poses=10, points=6, seed=1).dataset
    calibration = robolaser.calibrate(dataset)
    keeps_its_contract(calibration, "calibration", tmp_path)
    assert calibration.to_frame().loc["b", "value"] == calibration.value("b")
    assert len(str(calibration).splitlines()) <= 25
    for one in (calibration, robolaser.load_calibration(tmp_path / "calibration")):
        assert one.value("b") == calibration.value("b")
        with pytest.raises(UsageError, match=r"No parameter 'nothere'\. There are: f, s_u, s_v"):
            one.value("nothere")
    assert (
        repr(dataset)
        == "<Dataset simulated-scorbot_er7: laser stripe scanner, robot scorbot_er7, 60 points in 10 poses>"
    )

    diagnosis = robolaser.diagnose(dataset, effects=[], seed=1)
    keeps_its_contract(diagnosis, "diagnosis", tmp_path)
    assert diagnosis["effects"] == diagnosis.to_dict()["effects"]

    for result, load, kind in (
        (calibration, robolaser.load_calibration, "calibration"),
        (diagnosis, robolaser.load_diagnosis, "diagnosis"),
    ):
        read = load(tmp_path / kind)
        assert read.to_dict() == result.to_dict() == load(tmp_path / kind / f"{kind}.json").to_dict()
        (tmp_path / "again").mkdir(exist_ok=True)
        keeps_its_contract(read, kind, tmp_path / "again")


def test_a_comparison_is_a_result_too(tmp_path):
    told: list[tuple[str, float]] = []
    keeps_its_contract(
        robolaser.compare(
            ["pymoo:sphere-2"], ["de"], seeds=1, budget=100, progress=lambda what, share: told.append((what, share))
        ),
        "comparison",
        tmp_path,
    )
    assert re.match("[01]/1 runs", told[0][0])
