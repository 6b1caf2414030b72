"""`simulation.drive`: velocities, tables, and mistakes in them."""

from __future__ import annotations

from pathlib import Path

import pytest

from sweeps.config.load import ConfigError, from_mapping, from_yaml, load
from sweeps.config.pull import PulledError
from sweeps.engine.run import run_in_memory

GOOD = "elapsed_time,velocity\n0,2e-6\n1,0\n"


def written(folder: Path, table: str) -> Path:
    (folder / "pull.csv").write_text(table)
    config = folder / "pull.yaml"
    config.write_text("simulation:\n  drive: {table: pull.csv}\n")
    return config


def test_a_table_is_read_from_the_folder_of_the_config(tmp_path: Path) -> None:
    config = load(written(tmp_path, GOOD))
    assert config.simulation.drive.nodes == ((0.0, 2e-6), (1.0, 0.0))
    assert from_yaml(config.resolved_yaml()).simulation == config.simulation  # needs no table


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("", r"pull.csv holds no data"),
        ("elapsed_time;velocity\n0;1\n", "separate cells with commas"),
        (
            "time,velocity\n0,1\n",
            "pull.csv:1: needs exactly one column each of .* elapsed_time is missing",
        ),
        ("elapsed_time,velocity,velocity\n0,1,2\n", "velocity is given twice"),
        ("elapsed_time,velocity\n", "holds no data"),
        (GOOD + "2\n", "pull.csv:4: 1 cell for 2 columns"),
        (
            GOOD + "2,fast\n",
            "pull.csv:4, column velocity: must be a number in SI units, not 'fast'",
        ),
        (GOOD + "2,nan\n", "pull.csv:4, column velocity: must be a number in SI units, not 'nan'"),
        (GOOD + "2,inf\n", "pull.csv:4, column velocity: must be a finite number, not inf"),
        (GOOD + "2,\n", "pull.csv:4, column velocity: is empty"),
        (GOOD + "2,1\n" * 20_000, "has 20002 rows, more than 20000"),
        (
            GOOD + "\n0.5,0\n",
            "pull.csv:5: elapsed_time falls from 1 s to 0.5 s; times must not decrease",
        ),
        (GOOD + "1,1e-6\n1,0\n", "pull.csv:5: elapsed_time is 1 s in three rows"),
        ("elapsed_time,velocity\n0,0\n1,0\n", "nothing would be pulled"),
    ],
)
def test_a_mistake_in_a_table_is_reported_with_its_line(
    tmp_path: Path, table: str, message: str
) -> None:
    with pytest.raises(ConfigError, match=message) as caught:
        load(written(tmp_path, table))
    assert "pull.yaml:2: simulation.drive" in str(caught.value)


def test_all_mistakes_in_a_table_are_reported_at_once(tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as caught:
        load(written(tmp_path, GOOD + "2,fast\nlate,1\n"))
    assert "pull.csv:4" in str(caught.value)
    assert "pull.csv:5" in str(caught.value)


def test_a_step_of_the_velocity_is_two_rows_at_one_time(tmp_path: Path) -> None:
    step = "# sliding, then faster\nelapsed_time,velocity,note\n0,1e-6,a\n1,1e-6,\n1,5e-6,b\n"
    config = load(written(tmp_path, step))
    assert config.simulation.drive.nodes == ((0.0, 1e-6), (1.0, 1e-6), (1.0, 5e-6))


@pytest.mark.parametrize(
    ("simulation", "more", "message"),
    [
        ({"drive": {}}, {}, "needs exactly one of velocity, table, nodes"),
        ({"drive": {"velocity": 1e-6, "nodes": [[0, 1e-6]]}}, {}, "needs exactly one of"),
        ({"drive": {"table": "a.csv", "nodes": [[0, 1e-6]]}}, {}, "needs exactly one of"),
        ({"drive": {"speed": 1e-6}}, {}, "unknown key"),
        ({"drive": {"velocity": 1e-6}}, {}, "needs a `duration`"),
        ({"duration": 1}, {}, "`duration` belongs to a `drive`"),
        ({"samples": 300}, {}, "`samples` belongs to a `drive`"),
        ({"drive": {"nodes": [[1, 1e-6], [0, 1e-6]]}}, {}, "row 1: elapsed_time"),
        ({"drive": {"nodes": [[0, 1], [1, 1]]}, "start": "stationary"}, {}, "start: stationary"),
        ({"drive": {"nodes": [[0, 1], [1, 1]]}, "schedule": {"T": [200]}}, {}, "`schedule` bel"),
        (
            {"drive": {"nodes": [[0, 1], [1, 1]]}},
            {"integrator": {"method": "euler-cromer"}},
            "cannot be combined with `integrator: {method: euler-cromer}`",
        ),
        (
            {"drive": {"nodes": [[0, 1], [1, 1]]}},
            {"noise": {"treatment": "stochastic"}},
            "cannot be combined with `noise: {treatment: stochastic}`",
        ),
    ],
)
def test_a_wrong_drive_is_refused(simulation: dict, more: dict, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        from_mapping({"simulation": simulation} | more)


def test_a_sweep_of_a_pull_is_refused() -> None:
    pulled = {"simulation": {"drive": {"velocity": 1e-6}, "duration": 1}}
    with pytest.raises(PulledError, match="use `stickslip simulate`, or leave the drive out"):
        run_in_memory(from_mapping(pulled | {"sweep": {"T": [200, 250]}}))
