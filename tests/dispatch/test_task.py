"""Workers compute each point once, from its parameters alone, and no point harms another."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import fields, replace
from itertools import product
from typing import Any

import numpy as np
import pytest

from stickslip import Options, Status
from stickslip.compiled.cache import processor, source_hash
from stickslip.dispatch import task as worker
from stickslip.dispatch import thread_pool
from stickslip.dispatch.errors import ExecutorError, WorkerMismatchError
from stickslip.dispatch.in_flight import InFlight
from stickslip.dispatch.task import Block, Task, compute_block, failed_block, is_answer
from stickslip.kernels.families import KIND
from stickslip.orbit import compute_orbits, failed_row
from stickslip.plausibility import suspicious_balance, suspicious_stress
from stickslip.variables import RESULT_COLUMNS
from sweeps.config.load import from_mapping
from sweeps.config.schema import Execution
from sweeps.engine.computing import kinds_of
from sweeps.engine.run import compute
from sweeps.files.result_rows import STATUS, failures, status_counts
from sweeps.grid import Grid

# Different lubricants and temperatures, so that neighbours in a block differ in cost.
CONFIG = from_mapping(
    {
        "sweep": {"T": [180, 220, 260, 300], "gamma": [-2 / 3, 0, 2 / 3]},
        "integrator": {"rtol": 1e-4},
        "stationary": {"rtol": 1e-4},
    }
)
GRID = Grid.from_config(CONFIG)
EVERYTHING = np.arange(GRID.size)
POINTS = GRID.points(0, GRID.size)
OPTIONS = Options(rtol=1e-4, stationary_rtol=1e-4)


def computed(workers: int = 1, block_points: int | None = None, **settings: Any) -> np.ndarray:
    execution = Execution(workers=workers, block_points=block_points)
    return compute(CONFIG.model_copy(update={"execution": execution}), **settings)


def task_of(indices: np.ndarray) -> Task:
    """Return the task to compute some of the points."""
    return Task(indices, POINTS[indices], OPTIONS, source_hash())


def failures_of(block: Block) -> int:
    """Return the number of points in a block that did not end ok."""
    return failures(status_counts(block.results[:, STATUS]))


@pytest.fixture(scope="module")
def reference() -> np.ndarray:
    results = computed()
    assert np.all(results[:, -1] == Status.OK)
    return results


@pytest.mark.parametrize("workers", [1, 2, 8])
@pytest.mark.parametrize("block_points", [1, 3, None, 100])
def test_results_depend_neither_on_workers_nor_on_blocks(
    reference: np.ndarray, workers: int, block_points: int | None
) -> None:
    assert computed(workers, block_points).tobytes() == reference.tobytes()


def test_a_point_does_not_depend_on_its_neighbours(reference: np.ndarray) -> None:
    alone = np.array([compute_orbits(point, OPTIONS)[0][0] for point in POINTS])
    assert alone.tobytes() == reference.tobytes()
    backwards = compute_orbits(POINTS[::-1], OPTIONS)[0][::-1]
    assert backwards.tobytes() == reference.tobytes()
    among_copies = compute_orbits(np.repeat(POINTS, 3, axis=0), OPTIONS)[0]
    assert among_copies.tobytes() == np.repeat(reference, 3, axis=0).tobytes()


@pytest.mark.parametrize("workers", [1, 2, 8])
def test_each_block_is_reported_once_in_the_calling_thread(
    reference: np.ndarray, workers: int
) -> None:
    blocks: list[Block] = []

    def take(block: Block) -> None:
        assert threading.current_thread() is threading.main_thread()
        blocks.append(block)

    computed(workers, 5, on_block=take)
    assert sorted(len(block.indices) for block in blocks) == [2, 5, 5]
    assert sorted(np.concatenate([block.indices for block in blocks])) == list(range(12))
    for block in blocks:
        assert block.results.tobytes() == reference[block.indices].tobytes()
        assert (failures_of(block), block.messages) == (0, ())
        assert block.seconds > 0.0
        assert block.processor == processor()


def test_a_block_is_computed_from_its_task_alone(reference: np.ndarray) -> None:
    indices = np.array([1, 4, 11])
    task = task_of(indices)
    np.testing.assert_array_equal(task.points, POINTS[indices])
    block = compute_block(task)
    np.testing.assert_array_equal(block.indices, indices)
    assert block.results.tobytes() == reference[indices].tobytes()


def damaged(block: Block, name: str, value: float) -> Block:
    results = block.results.copy()
    results[0, RESULT_COLUMNS.index(name)] = value
    return replace(block, results=results).sealed()


def with_another_bit(block: Block) -> Block:
    """The block as it may come back from a worker; no range of values reveals the damage."""
    results = block.results.copy()
    results.view(np.uint64)[0, RESULT_COLUMNS.index("friction_force_in_phase")] ^= np.uint64(1)
    return replace(block, results=results)


NOT_BLOCKS: dict[str, Callable[[Block], Any]] = {
    "nothing": lambda _: None,
    "a text": lambda _: "a text",
    "no points": lambda block: block.part(np.zeros(len(block.indices), dtype=bool)),
    "unknown points": lambda block: replace(block, indices=block.indices + GRID.size),
    "texts for numbers of points": lambda block: replace(block, indices=["a", "b"]),
    "no numbers of points": lambda block: replace(block, indices=None),
    "one number of a point": lambda block: replace(block, indices=np.int64(0)),
    "infinite numbers of points": lambda block: replace(block, indices=np.array([np.inf])),
}

# A shared cluster, or another version of a pickled class, may send anything.
ODD = [None, "a text", b"bytes", -1, 1.5, np.nan, 10**400, [], (), {}, object(), np.array([1.5])]

WRONG_BLOCKS: dict[str, Callable[[Block], Block]] = {
    "another point": lambda block: replace(block, indices=block.indices + np.arange(2)),
    "too few rows": lambda block: replace(block, results=block.results[:1]),
    "other floats": lambda block: replace(block, results=block.results.astype(np.float32)),
    "a list": lambda block: replace(block, results=block.results.tolist()),
    "an unknown status": lambda block: damaged(block, "status", 77.0),
    "a point left over": lambda block: damaged(block, "status", Status.PENDING),
    "a point interpolated": lambda block: damaged(block, "status", Status.INTERPOLATED),
    "a failure with amplitudes": lambda block: damaged(block, "status", Status.FAILED),
    "no amplitude": lambda block: damaged(block, "elastic_stress_amplitude", np.nan),
    "an infinite maximum": lambda block: damaged(block, "elastic_stress_max", np.inf),
    "a negative amplitude": lambda block: damaged(block, "friction_force_amplitude", -1e-3),
    "a maximum below the minimum": lambda block: damaged(block, "friction_force_max", -1.0),
    "an amplitude above its extrema": lambda block: damaged(
        block, "elastic_stress_amplitude", 1e300
    ),
    "a maximum beyond the amplitude": lambda block: damaged(block, "elastic_stress_max", 1e300),
    "an unknown regime": lambda block: damaged(block, "regime", 99.0),
    "an error beyond all": lambda block: damaged(block, "amplitude_error", 1e300),
    "half a melting": lambda block: damaged(block, "melting_count", 0.5),
    "another bit": with_another_bit,
    "a masked array": lambda block: replace(block, results=np.ma.array(block.results)),
    "floats for numbers of points": lambda block: replace(block, indices=block.indices * 1.0),
    "three counts": lambda block: replace(block, suspicious=(0, 0, 0)),
}


@pytest.mark.parametrize("case", [*NOT_BLOCKS, *WRONG_BLOCKS])
def test_an_answer_that_cannot_be_the_block_ends_the_sweep(
    monkeypatch: pytest.MonkeyPatch, case: str
) -> None:
    wrong = (NOT_BLOCKS | WRONG_BLOCKS)[case]
    monkeypatch.setattr(thread_pool, "compute_block", lambda task: wrong(compute_block(task)))
    with pytest.raises(ExecutorError, match="returned something other than its block"):
        computed(block_points=2)


@pytest.mark.parametrize("name", [field.name for field in fields(Block)])
def test_no_field_of_an_answer_may_be_of_another_type(name: str, reference: np.ndarray) -> None:
    task = task_of(EVERYTHING)
    block = Block(EVERYTHING, reference, 1.0, "a processor", (0, 0), ()).sealed()
    assert is_answer(block, task)
    in_flight = InFlight()
    for value in ODD:
        odd = replace(block, **{name: value})
        allowed = {"seconds": [1.5], "processor": ["a text"], "messages": [()]}.get(name, [])
        assert is_answer(odd, task) == any(repr(value) == repr(each) for each in allowed)
        in_flight.begin(task)
        in_flight.end(odd)


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("case", WRONG_BLOCKS)
def test_a_block_that_came_back_damaged_is_computed_again(
    reference: np.ndarray,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    case: str,
    workers: int,
) -> None:
    damages = [WRONG_BLOCKS[case]]

    def compute_some(task: Task) -> Any:
        block = compute_block(task)
        return damages.pop()(block) if damages else block

    monkeypatch.setattr(thread_pool, "compute_block", compute_some)
    assert computed(workers, block_points=2).tobytes() == reference.tobytes()
    assert caplog.messages == ["a block came back damaged from a worker; it is computed again"]


def test_a_worker_with_other_sources_computes_nothing() -> None:
    task = task_of(EVERYTHING)
    other = Task(task.indices, task.points, task.options, "0123456789abcdef")
    with pytest.raises(WorkerMismatchError, match=r"code .*differs from .*0123456789ab"):
        compute_block(other)


def test_a_block_counts_the_results_that_look_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    def odd(points: np.ndarray, options: Options, **how: Any) -> tuple[np.ndarray, np.ndarray]:
        results, finals = compute_orbits(points, options, **how)
        results[:5, RESULT_COLUMNS.index("power_balance_error")] = 5e-3
        results[:5, RESULT_COLUMNS.index("amplitude_error")] = 5e-3
        results[5:9, RESULT_COLUMNS.index("power_balance_error")] = 5e-3  # but well known
        results[4:7, RESULT_COLUMNS.index("elastic_stress_max")] *= 100.0
        assert suspicious_balance(results).sum() == 5
        assert suspicious_stress(points, results).sum() == 3
        return results, finals

    task = task_of(EVERYTHING)
    assert compute_block(task).suspicious == (0, 0)
    monkeypatch.setattr(worker, "compute_orbits", odd)
    assert compute_block(task).suspicious == (5, 3)


# --- exceptions ---


def poisoned(temperature: float) -> Callable[..., tuple[np.ndarray, np.ndarray]]:
    """`compute_orbits`, which raises where a point has this temperature."""

    def compute_some(
        points: np.ndarray, options: Options, **how: Any
    ) -> tuple[np.ndarray, np.ndarray]:
        if np.any(np.atleast_2d(points)[:, 0] == temperature):
            raise ZeroDivisionError("poison")
        return compute_orbits(points, options, **how)

    return compute_some


@pytest.mark.parametrize("block_points", [None, 1, 5])
@pytest.mark.parametrize("workers", [1, 2])
def test_an_exception_costs_only_its_own_points(
    reference: np.ndarray,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    workers: int,
    block_points: int | None,
) -> None:
    monkeypatch.setattr(worker, "compute_orbits", poisoned(260.0))
    blocks: list[Block] = []
    results = computed(workers, block_points, on_block=blocks.append)
    lost = POINTS[:, 0] == 260.0
    assert results[~lost].tobytes() == reference[~lost].tobytes()
    assert lost.sum() == sum(map(failures_of, blocks)) == 3
    for row in results[lost]:
        np.testing.assert_array_equal(row, failed_row())
        assert row[-1] == Status.FAILED
    logged = [record for record in caplog.records if "computation of point" in record.message]
    assert len(logged) == 3
    assert all(record.levelname == "ERROR" and not record.exc_info for record in logged)
    assert [r.message for r in logged] == [text for block in blocks for text in block.messages]
    assert caplog.text.count("ZeroDivisionError('poison')") == 3
    for point in POINTS[lost]:
        assert str(point.tolist()) in caplog.text


def test_points_that_no_worker_survives_fail_with_a_message() -> None:
    block = failed_block(task_of(np.array([3, 7])), "the worker died")
    np.testing.assert_array_equal(block.indices, [3, 7])
    np.testing.assert_array_equal(block.results, [failed_row(), failed_row()])
    assert failures_of(block) == 2
    assert block.messages == tuple(
        f"point {POINTS[number].tolist()} failed: the worker died" for number in (3, 7)
    )


@pytest.mark.parametrize("workers", [1, 2])
def test_ctrl_c_does_not_count_as_a_failed_point(
    monkeypatch: pytest.MonkeyPatch, workers: int
) -> None:
    presses = [KeyboardInterrupt]

    def interrupted(
        points: np.ndarray, options: Options, **how: Any
    ) -> tuple[np.ndarray, np.ndarray]:
        if presses:
            raise presses.pop()
        return compute_orbits(points, options, **how)

    monkeypatch.setattr(worker, "compute_orbits", interrupted)
    with pytest.raises(KeyboardInterrupt):
        computed(workers)


def test_kinds_show_whether_a_coefficient_is_0_and_not_its_value() -> None:
    config = from_mapping({"sweep": {"gamma": [0, 0.5], "d": [0, 1, 2], "e": [1, 2, 3]}})
    found = kinds_of(Grid.from_config(config))
    assert len(found) == 2 * 2 * 1
    assert set(map(tuple, found[:, :2] != 0.0)) == set(product((False, True), repeat=2))
    assert np.all(found[:, KIND.index("sextic_coefficient")] > 0.0)
