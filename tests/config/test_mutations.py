"""One mistake in a shipped config: it is read, or refused with the line of the mistake."""

from __future__ import annotations

import random
import re
from collections import Counter
from collections.abc import Callable
from typing import NamedTuple

import pytest
from support.marks import marked
from support.sweeps.configs import CONFIGS, SHIPPED

from sweeps.config.load import ConfigError, from_yaml

COMMENT = re.compile(r"(?m)(^|\s+)#.*$")
KEY = re.compile(r"[A-Za-z_]\w*(?=:)")
VALUE = re.compile(r"(?<=: )[^\s,{}\[\]#][^,{}\[\]#\n]*|(?<=\[)[^,\]\[{}]+")
WRONG_VALUES = ("x", "-1", "0", "null", "true", "[1]", "{a: 1}", "1e400", ".nan", "1,5 K", "'")


class Mutation(NamedTuple):
    """A config with one mistake in `line`, and whether a message must name that very line."""

    text: str
    line: int
    told_there: bool


def misspelt(text: str, rng: random.Random) -> Mutation:
    """A key lacks a letter in its middle."""
    key = rng.choice(list(KEY.finditer(text)))
    cut = rng.randrange(key.start(), key.end())
    return Mutation(text[:cut] + text[cut + 1 :], line_of(text, cut), told_there=True)


def another_value(text: str, rng: random.Random) -> Mutation:
    """A value of another type, sign or size, which may be allowed."""
    value = rng.choice(list(VALUE.finditer(text)))
    changed = text[: value.start()] + rng.choice(WRONG_VALUES) + text[value.end() :]
    return Mutation(changed, line_of(text, value.start()), told_there=False)


def given_twice(text: str, rng: random.Random) -> Mutation:
    """A line with a key is repeated."""
    lines = text.splitlines(keepends=True)
    keyed = [i for i, line in enumerate(lines) if re.match(r" *[A-Za-z_]\w*: *\S", line)]
    chosen = rng.choice(keyed)
    lines.insert(chosen, lines[chosen])
    return Mutation("".join(lines), chosen + 2, told_there=True)


def character_lost(text: str, rng: random.Random) -> Mutation:
    """A colon, a bracket, a comma or a quote is missing."""
    place = rng.choice([i for i, character in enumerate(text) if character in ":[]{},'\""])
    return Mutation(text[:place] + text[place + 1 :], line_of(text, place), told_there=False)


def indented(text: str, rng: random.Random) -> Mutation:
    """A line is indented by one more space, or by a tab."""
    lines = text.splitlines(keepends=True)
    chosen = rng.randrange(len(lines))
    lines[chosen] = rng.choice(" \t") + lines[chosen]
    return Mutation("".join(lines), chosen + 1, told_there=False)


def line_lost(text: str, rng: random.Random) -> Mutation:
    lines = text.splitlines(keepends=True)
    chosen = rng.randrange(len(lines))
    return Mutation("".join(lines[:chosen] + lines[chosen + 1 :]), chosen + 1, told_there=False)


def line_of(text: str, place: int) -> int:
    return text.count("\n", 0, place) + 1


MUTATE: tuple[Callable[[str, random.Random], Mutation], ...] = (
    misspelt,
    another_value,
    given_twice,
    character_lost,
    indented,
    line_lost,
)


@pytest.mark.parametrize("count", [150, *marked("stress", [1500])])
def test_a_mistake_is_refused_with_its_line(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(CONFIGS)  # where the tables are that configs name
    rng, outcomes = random.Random(20261128), Counter[str]()
    for number in range(count):
        mutate = MUTATE[number % len(MUTATE)]
        text = COMMENT.sub("", rng.choice(SHIPPED).read_text()).lstrip()
        outcomes[f"{mutate.__name__}: {outcome(mutate(text, rng))}"] += 1
    assert outcomes["misspelt: read"] == outcomes["given_twice: read"] == 0, outcomes


def outcome(mutation: Mutation) -> str:
    """Return `read`, or where the config is refused: on the line of the mistake, or elsewhere."""
    told = problems_of(mutation.text)
    if not told:
        return "read"
    lines = [place_of(message) for message in told]
    assert all(1 <= line <= mutation.text.count("\n") + 1 for line in lines), told
    assert mutation.line in lines or not mutation.told_there, f"{mutation}\n{told}"
    return "refused there" if mutation.line in lines else "refused elsewhere"


def problems_of(text: str) -> list[str]:
    try:
        from_yaml(text, "f.yaml").resolved_yaml()
    except ConfigError as error:
        return str(error).splitlines()
    return []


def place_of(message: str) -> int:
    found = re.match(r"f\.yaml:(\d+): ", message)
    assert found, message
    return int(found[1])
