"""Status: the stored codes are fixed, and each has a sentence for readers."""

import re

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
    "unstable": 10,
    "pending": 127,  # the largest int8: a file stores statuses as such
}


def test_codes_agree_with_the_file_format():
    assert {status.name.lower(): status.value for status in Status} == CODES


def test_each_status_has_a_different_sentence():
    sentences = [status.sentence for status in Status]
    assert all(re.fullmatch(r"[A-Z](?!.*\. ).*\.", sentence) for sentence in sentences)
    assert len(set(sentences)) == len(sentences)
