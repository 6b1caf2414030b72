"""Tables of measurements: their content, and messages about mistakes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from sweeps import fit
from sweeps.measurements import DataError, read_data

FIVE = """\
T,K,F_max,F_max_error
200,3000,0.003
-5,3000,0.003,1e-5
210,3000,"0,0028",1e-5
220,3000,0.0027,0
230,,0.0026,1e-5
"""
FIVE_MESSAGES = [
    "five.csv:2: 3 cells for 4 columns; a missing value needs an empty cell",
    "five.csv:3, column T: must be at least 0, not -5.0",
    "five.csv:4, column F_max: must be a number in SI units, not '0,0028' "
    "(use a decimal point, and no thousands separators)",
    "five.csv:5, column F_max_error: must be greater than 0, not 0.0",
    "five.csv:6, column K: is empty; each row needs a value here",
]


def test_a_file_is_read_with_its_errors(tmp_path: Path) -> None:
    path = tmp_path / "data.csv"
    path.write_text(
        "\ufeffT, F_max ,friction_force_amplitude_error\n"
        "# a comment\n\n200, 3e-3, 1e-5\n250,,\n300, 2e-3, 2e-5\n"
    )
    data = read_data(path)
    np.testing.assert_array_equal(data.parameters["temperature"], [200, 250, 300])
    assert data.variable == ("friction_force_amplitude",) * 2
    np.testing.assert_array_equal(data.row, [0, 2])
    np.testing.assert_array_equal(data.value, [3e-3, 2e-3])
    np.testing.assert_array_equal(data.error, [1e-5, 2e-5])
    assert not data.relative


@pytest.mark.parametrize("name", ["dissipated_energy", "W", "friction_force_in_phase", "F'"])
def test_an_error_column_belongs_to_the_measurement_even_if_the_model_has_an_error_too(
    name: str,
) -> None:
    data = read_data({"T": [200, 250], name: [3e-9, 2e-9], f"{name}_error": [1e-10, 2e-10]})
    assert len(set(data.variable)) == 1
    np.testing.assert_array_equal(data.value, [3e-9, 2e-9])
    np.testing.assert_array_equal(data.error, [1e-10, 2e-10])


def test_without_errors_they_are_relative() -> None:
    table = {"omega": [10, 20], "F_max": [3e-3, 2e-3], "elastic_stress_amplitude": [1e6, np.nan]}
    data = read_data(pd.DataFrame(table))
    assert data.relative
    np.testing.assert_array_equal(data.error, data.value)
    np.testing.assert_array_equal(data.row, [0, 1, 0])


def test_a_point_may_be_measured_again_and_again_without_a_parameter() -> None:
    data = read_data({"F_max": [2.9e-3, 2.8e-3, 3.0e-3]})
    assert data.rows == 3
    ds = fit({"F_max": [2.9e-3, 2.8e-3, 3.0e-3]}, "k")
    np.testing.assert_array_equal(ds.datum_row, [0, 1, 2])
    assert ds.fitted_value.values == pytest.approx(2.9e-3, rel=0.01)


def test_parameters_in_the_index_of_a_table_are_columns() -> None:
    table = pd.DataFrame({"run": [1, 2], "T": [200.0, 210.0], "F_max": [3e-3, 2e-3]})
    for index in ("T", ["run", "T"]):
        frame = table.set_index(index).drop(columns="run", errors="ignore")
        np.testing.assert_array_equal(read_data(frame).parameters["temperature"], [200.0, 210.0])


def test_five_mistakes_are_reported_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("five.csv").write_text(FIVE)
    with pytest.raises(DataError) as raised:
        read_data("five.csv")
    assert str(raised.value).splitlines() == FIVE_MESSAGES


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"temprature": [1], "F_max": [1]}, "did you mean 'temperature'?"),
        ({"T": [1], "Friction force (mN)": [1]}, "'F_max'?); leave units out of names"),
        ({"T": [1], "F_max": [1], "dF": [1]}, "table, column dF: is neither"),
        ({"T": [1], "shear stress": [1]}, "did you mean 'elastic_stress_amplitude'?"),
        ({"T": [1, -1], "F_max": [1, 1]}, "row 1, column T: must be at least 0"),
        ({"T": [1, 2], "F_max": [1, 1], "F_max_error": [1, None]}, "row 1, column F_max: a value"),
        ({"T": [1], "amplitude_error": [1], "F_max": [1]}, "nor the error of one"),
        ({"T": [200], "temperature": [200], "F_max": [1]}, "temperature is given twice"),
        ({"T": [200]}, "no column is a measured variable"),
        ({"T": [200], "F_max_error": [1e-5]}, "there is no column friction_force_amplitude"),
        (
            {"F_max": [1], "F_max_error": [1], "elastic_stress_amplitude": [1]},
            "there are none for elastic_stress_amplitude",
        ),
        ({"T": [200], "F_max": [0.0]}, "row 0, column F_max: an error relative to a value of 0"),
        ({"F_max": [1.0], "F_max_error": [np.nan]}, "a value without an error; fill in"),
        ({"T": [200], "F_max": [np.inf]}, "must be a finite number"),
        ({"T": [200], "F_max": [np.nan]}, "there are no measured values"),
        ({"T": []}, "holds no data"),
        ({"T": [1, 2], "F_max": [1]}, "need the same number of values, but have: T 2, F_max 1"),
        ({"T": 200.0, "F_max": 3e-3}, "each column must be a list of numbers"),
        (3, "data must be a CSV file, DataFrame or dict"),
    ],
)
def test_mistakes_in_tables(table: object, message: str) -> None:
    with pytest.raises(DataError) as raised:
        read_data(table)
    assert message in str(raised.value)


def test_only_the_first_twenty_mistakes_are_shown() -> None:
    with pytest.raises(DataError, match="and 10 more") as caught:
        read_data({"T": ["x"] * 30, "F_max": [1] * 30})
    assert str(caught.value).count("\n") == 20
