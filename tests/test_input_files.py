"""Text files that people write, read as text and as tables."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from sweeps.config.load import ConfigError, load
from sweeps.input_files import DataError, UnreadableError, number_in, table_of
from sweeps.measurements import read_data

ROWS = "160,3e-3,4e-5\n200,2e-3,4e-5\n"


def of_config(path: Path) -> object:
    """Read the file as the table of a pull."""
    config = path.with_name("pull.yaml")
    config.write_text(f"simulation:\n  drive: {{table: {path.name}}}\n")
    return load(config)


@pytest.mark.parametrize("read", [read_data, of_config, load])
def test_only_regular_files_are_opened(read, tmp_path: Path) -> None:
    """A FIFO would wait for a writer, and a device would fill the memory."""
    os.mkfifo(tmp_path / "fifo")
    (tmp_path / "zero").symlink_to("/dev/zero")
    for name in ("fifo", "zero"):
        with pytest.raises((UnreadableError, ConfigError), match=r"is not a regular file"):
            read(tmp_path / name)


@pytest.mark.parametrize("read", [read_data, of_config, load])
def test_a_missing_file_cannot_be_read(read, tmp_path: Path) -> None:
    with pytest.raises((UnreadableError, ConfigError), match=r"cannot be read: No such file"):
        read(tmp_path / "none.csv")


@pytest.mark.parametrize("read", [read_data, of_config])
def test_a_table_has_a_limit_of_bytes_and_columns(read, tmp_path: Path) -> None:
    path = tmp_path / "large.csv"
    path.write_bytes(b"\0" * ((4 << 20) + 1))
    with pytest.raises((DataError, ConfigError), match=r"larger than 4 MiB, too large for a table"):
        read(path)
    path.write_text("a," * 1000 + "a\n" + "1," * 1000 + "1\n")
    with pytest.raises((DataError, ConfigError), match=r"has 1001 columns, too many for a table"):
        read(path)


@pytest.mark.parametrize("read", [read_data, load])
def test_no_file_has_a_nul_in_its_name(read) -> None:
    with pytest.raises((UnreadableError, ConfigError), match=r"its name contains a NUL character"):
        read(Path("a\0b"))


def test_a_pull_whose_name_has_a_nul(tmp_path: Path) -> None:
    config = tmp_path / "pull.yaml"
    config.write_text('simulation: {drive: {table: "a\\0b"}}\n')
    with pytest.raises(ConfigError, match=r"NUL|control"):
        load(config)


@pytest.mark.parametrize("read", [read_data, of_config])
@pytest.mark.parametrize("cell", ["x" * 140_000, '"0.003\n' + "1,2\n" * 40_000])
def test_a_huge_cell_is_reported_with_its_line(read, cell: str, tmp_path: Path) -> None:
    path = tmp_path / "huge.csv"
    path.write_text(f"T,F_max\n200,{cell}\n")
    with pytest.raises(
        (DataError, ConfigError), match=r"characters; is a closing quote missing"
    ) as caught:
        read(path)
    assert "huge.csv:2" in str(caught.value) or cell.startswith('"')
    assert len(str(caught.value)) < 1000


def test_long_cells_and_names_are_shortened(tmp_path: Path) -> None:
    path = tmp_path / "long.csv"
    for table in (f"T,F_max\n200,{'x' * 1000}\n", f"T,{'x' * 1000}\n200,1\n"):
        path.write_text(table)
        with pytest.raises(DataError) as caught:
            read_data(path)
        assert max(map(len, str(caught.value).splitlines()[:1])) < 300


@pytest.mark.parametrize(
    ("encoding", "line"),
    [("utf-16", 1), ("utf-16-le", 2), ("utf-16-be", 2), ("utf-32", 1), ("latin-1", 2)],
)
@pytest.mark.parametrize("read", [read_data, of_config, load])
def test_other_encodings_than_utf_8_are_refused_with_the_remedy(
    read, encoding: str, line: int, tmp_path: Path
) -> None:
    path = tmp_path / "other.csv"
    path.write_bytes("T,F_max\n20,1 # µ\n".encode(encoding))
    with pytest.raises(
        (DataError, ConfigError), match=rf"other.csv:{line}: is not UTF-8 text; save the file"
    ):
        read(path)


def test_a_table_in_utf_16_without_a_mark_is_refused(tmp_path: Path) -> None:
    (tmp_path / "other.csv").write_bytes("T,F_max\n20,1\n".encode("utf-16-le"))
    with pytest.raises(DataError, match=r"other.csv:1: is not UTF-8 text"):
        read_data(tmp_path / "other.csv")


@pytest.mark.parametrize(
    "head",
    [
        "# T,F_max,F_max_error\n",
        "#T, F_max, F_max_error\n",
        "# run 4, of 2022\n# T,F_max,F_max_error\n",
        "# T,F_max,F_max_error\n# run 4, of 2022\n",
        "# all, in, SI\nT,F_max,F_max_error\n",
        "\ufeffT,F_max,F_max_error\n# a, b, c\n",
    ],
)
def test_a_table_without_names_takes_them_from_a_comment(head: str, tmp_path: Path) -> None:
    path = tmp_path / "saved.csv"
    path.write_text(head + ROWS + "# end, of, it\n")
    table = table_of(path)
    assert table.header == ["T", "F_max", "F_max_error"]
    assert table.cells == [row.split(",") for row in ROWS.splitlines()]
    assert path.read_text().splitlines()[table.head - 1].lstrip("\ufeff# ").startswith("T")


def test_what_numpy_writes_is_read(tmp_path: Path) -> None:
    path = tmp_path / "saved.csv"
    columns = np.array([[160.0, 0.0046662], [200.0, 0.0034764]])
    np.savetxt(path, columns, delimiter=",", header="T,F_max")
    data = read_data(path)
    np.testing.assert_array_equal(data.parameters["temperature"], columns[:, 0])
    np.testing.assert_array_equal(data.value, columns[:, 1])
    np.savetxt(path, columns, header="T F_max")  # separated by spaces, its default
    with pytest.raises(DataError, match=r"saved.csv:2: separate cells with commas, not"):
        read_data(path)
    np.savetxt(path, columns, delimiter=",")
    with pytest.raises(DataError, match=r"saved.csv:1: holds numbers; the line of column names"):
        read_data(path)


def test_a_mistake_among_names_in_a_comment_has_its_line(tmp_path: Path) -> None:
    path = tmp_path / "saved.csv"
    path.write_text("# run 4\n# T,force,F_max_error\n" + ROWS)
    with pytest.raises(DataError, match=r"saved.csv:2, column force: "):
        read_data(path)


@pytest.mark.parametrize(
    "marker", ["n.a.", "-", "NaN", "#N/A", "NA", "n/a", "none", "--", "–", "?"]
)
def test_a_marker_of_a_missing_value_is_refused_in_favour_of_an_empty_cell(
    marker: str, tmp_path: Path
) -> None:
    path = tmp_path / "data.csv"
    path.write_text(f"T,F_max\n200,{marker}\n{marker},3e-3\n")
    with pytest.raises(DataError) as caught:
        read_data(path)
    datum, parameter = str(caught.value).splitlines()
    assert datum.endswith(f"not {marker!r}; leave the cell empty where nothing was measured")
    assert parameter.endswith(f"not {marker!r}; each row needs a value here")


def test_a_typographic_minus_is_a_minus() -> None:
    assert number_in("\N{MINUS SIGN}0.5") == -0.5
    assert number_in("1e\N{MINUS SIGN}3") == 1e-3


@pytest.mark.parametrize(
    ("cell", "remedy"),
    [("0,0028", "use a decimal point"), ("1.5%", "write the number alone"), ("3 mN", "alone")],
)
def test_a_cell_without_a_number_is_refused_with_the_remedy(cell: str, remedy: str) -> None:
    with pytest.raises(ValueError, match=f"must be a number in SI units, not '{cell}'.*{remedy}"):
        number_in(cell)
