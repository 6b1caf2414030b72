import pytest

from sweeps.human import clock, counted, did_you_mean, duration, points_per_time, reason, size_text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.04, "0.0 s"),
        (8.44, "8.4 s"),
        (59.94, "59.9 s"),
        (59.96, "1 min 0 s"),
        (200.4, "3 min 20 s"),
        (3599.6, "1 h 0 min"),
        (7500.0, "2 h 5 min"),
    ],
)
def test_a_duration_never_says_sixty_seconds(seconds, text):
    assert duration(seconds) == text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.0, "0:00"), (8.9, "0:08"), (200.0, "3:20"), (3599.9, "59:59"), (7507.0, "2:05:07"),
     (360_000.0, "100:00:00")],
)  # fmt: skip
def test_a_clock_goes_on_second_by_second(seconds, text):
    assert clock(seconds) == text


@pytest.mark.parametrize(
    ("points_per_second", "text"),
    [(833.33, "833.3 points/s"), (0.1, "0.1 points/s"), (0.09, "5.4 points/min"),
     (0.001, "3.6 points/h"), (0.0, "0.0 points/h")],
)  # fmt: skip
def test_a_rate_is_in_the_unit_that_shows_more_than_zero(points_per_second, text):
    assert points_per_time(points_per_second) == text


@pytest.mark.parametrize(
    ("count", "text"),
    [(0, "0 bytes"), (1023, "1023 bytes"), (1536, "1.5 KiB"), (3 * 2**20, "3.0 MiB"),
     (2**42, "4096.0 GiB")],
)  # fmt: skip
def test_a_size_is_in_the_unit_that_keeps_it_short(count, text):
    assert size_text(count) == text


def test_the_reason_of_a_system_error_is_its_text_alone(tmp_path):
    with pytest.raises(OSError, match="No such file") as caught:
        (tmp_path / "absent").read_text()
    assert reason(caught.value) == "No such file or directory"


def test_the_reason_of_another_error_is_its_message():
    assert reason(RuntimeError("NetCDF: HDF error")) == "NetCDF: HDF error"
    assert reason(OSError("the file does not read back")) == "the file does not read back"


def test_a_near_miss_gets_the_right_spelling():
    assert did_you_mean("Temprature", ["temperature", "K"]) == " (did you mean 'temperature'?)"
    assert did_you_mean("t_c", ["T_c", "K"]) == " (did you mean 'T_c'?)"
    assert did_you_mean("temp", ["temperature", "K"]) == " (did you mean 'temperature'?)"


def test_what_is_like_nothing_known_gets_no_hint():
    assert did_you_mean("zzz", ["temperature", "K"]) == ""
    assert did_you_mean("x" * 100_000, ["temperature"]) == ""


@pytest.mark.parametrize(("count", "text"), [(0, "0 points"), (1, "1 point"), (2, "2 points")])
def test_one_is_singular(count: int, text: str) -> None:
    assert counted(count, "point") == text
