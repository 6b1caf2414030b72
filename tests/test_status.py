"""Status: the stored codes are fixed, and each has a sentence for people."""

import numpy as np
import pytest

from stickslip.status import Status

CODES = {
    "ok": 0,
    "not_stationary": 1,
    "step_limit": 2,
    "diverged": 3,
    "refused": 4,
    "failed": 5,
    "invariant_violated": 6,
    "aperiodic": 7,
    "inaccurate": 8,
    "interpolated": 9,
    "pending": 127,
}


def test_codes_are_those_of_the_file_format():
    assert {status.name.lower(): status.value for status in Status} == CODES


def test_codes_fit_the_int8_of_the_file():
    assert [int(np.int8(status)) for status in Status] == list(Status)


@pytest.mark.parametrize("status", Status, ids=lambda s: s.name)
def test_each_status_has_one_sentence(status: Status):
    assert status.sentence[0].isupper()
    assert status.sentence.endswith(".")
    assert ". " not in status.sentence


def test_sentences_differ():
    assert len({status.sentence for status in Status}) == len(Status)
