"""Groups of keys, which make up a config, and messages about wrong keys and values."""

from __future__ import annotations

import re
from collections.abc import Container, Iterator, Mapping
from typing import Any, ClassVar, Self, TypeVar, get_args

from pydantic import (
    BaseModel,
    ConfigDict,
    ModelWrapValidatorHandler,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import ErrorDetails, InitErrorDetails, PydanticCustomError

from sweeps.config.numbers import number, whole
from sweeps.config.written_config import UNREADABLE, Document, Path, quoted
from sweeps.human import did_you_mean

# Pydantic's words and the words that replace them.
_WORDS = {
    "Input should be": "must be",
    "List should have": "must have",
    " after validation": "",
    "must be a valid dictionary": "must consist of lines `parameter: value`",
    "a valid list": "a list",
    "greater than or equal to": "at least",
    "less than or equal to": "at most",
}


_G = TypeVar("_G", bound="Group")


class Group(BaseModel):
    """A mapping in a config, declared by its keys; it refuses unknown keys.

    A group short enough for one line has an `example`.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    example: ClassVar[str] = ""

    @classmethod
    def written_keys(cls) -> list[str]:
        """Return the keys as users write them."""
        return [field.alias or name for name, field in cls.model_fields.items()]

    @classmethod
    def unknown_key(cls, key: str) -> str:
        """Return a complaint about an unknown key, with the right place or a similar known key."""
        keys = cls.written_keys()
        known = f"write {cls.example}" if cls.example else f"the known keys are {', '.join(keys)}"
        return f"unknown key{cls.home_of(key) or did_you_mean(key, keys) or f'; {known}'}"

    @classmethod
    def home_of(cls, key: str) -> str:
        """Return the place where a key belongs within this group, or an empty text."""
        paths = list(cls._paths_to(key))
        homes = " or ".join(f"`{path.rpartition('.')[0]}`" for path in paths)
        return f"; it belongs under {homes}: {' or '.join(paths)}" if paths else ""

    @classmethod
    def _paths_to(cls, key: str) -> Iterator[str]:
        for name, field in cls.model_fields.items():
            for inner in (field.annotation, *get_args(field.annotation)):
                if isinstance(inner, type) and issubclass(inner, Group):
                    found = [key] if key in inner.written_keys() else []
                    yield from (f"{name}.{path}" for path in (*found, *inner._paths_to(key)))

    @field_validator("*", mode="before")
    @classmethod
    def _as_written(cls, value: object, info: ValidationInfo) -> object:
        """Return the number behind the value of a numerical key; leave other values as they are."""
        kind = cls.model_fields[str(info.field_name)].annotation
        kinds = get_args(kind) or (kind,)
        if value is None and type(None) in kinds:
            return None
        if int in kinds:
            return whole(value)
        return number(value) if float in kinds else value

    @model_validator(mode="wrap")
    @classmethod
    def _refused_in_words(cls, value: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        try:
            return handler(value)
        except ValidationError as error:
            details = [cls._in_words(each) for each in error.errors(include_url=False)]
            raise ValidationError.from_exception_data(cls.__name__, details) from None

    @classmethod
    def _in_words(cls, details: ErrorDetails) -> InitErrorDetails:
        """Return an error of pydantic in the words of this project."""
        kind = details["type"]
        if kind == "extra_forbidden":
            message = cls.unknown_key(str(details["loc"][-1]))
        elif kind == "missing":
            message = f"is missing; write {cls.example}"
        elif kind == "model_type":
            keys = f"consist of lines `key: value` with the keys {', '.join(cls.written_keys())}"
            shape = f"be {cls.example}" if cls.example else keys
            message = f"must {shape}, not {quoted(details['input'])}"
        else:
            message = _general(details)
            if kind in ("list_type", "too_short", "too_long") and cls.example:
                message += f"; write {cls.example}"
        return InitErrorDetails(
            type=PydanticCustomError("config", message), loc=details["loc"], input=details["input"]
        )


def _general(details: ErrorDetails) -> str:
    if details["type"] == "config":  # an inner group has written the message
        return details["msg"]
    if details["type"] == "value_error":
        return str(details["ctx"]["error"])
    message, value = details["msg"], details["input"]
    for theirs, ours in _WORDS.items():
        message = message.replace(theirs, ours)
    for limit in details.get("ctx", {}).values():
        if isinstance(limit, float):
            message = re.sub(r"[\d.]+$", f"{limit:g}", message)
    if details["type"] in ("too_short", "too_long"):
        return message  # the message names the length
    names = re.findall("'(.*?)'", message) if isinstance(value, str) else ()
    return f"{message}, not {quoted(value)}{did_you_mean(value, names) if names else ''}"


def sound_parts(kind: type[_G], document: Document) -> tuple[_G, set[str]]:
    """Return the sound keys of a document, and the names of the unsound ones.

    Refuses wrong values and leaves them out: of a group only the wrong keys, if the others are
    valid without them, else the whole group.
    """
    data = document.data
    try:
        return kind.model_validate(_without(data, ())), set()
    except ValidationError as error:
        refused = _refused(document, error)
    unsound, left_out = {str(path[0]) for path in refused}, {path[:2] for path in refused}
    try:
        return kind.model_validate(_without(data, left_out)), unsound
    except ValidationError as error:  # other keys of a group need the missing key
        left_out |= {details["loc"][:1] for details in error.errors()}
        return kind.model_validate(_without(data, left_out)), unsound


def _refused(document: Document, error: ValidationError) -> set[Path]:
    """Refuse each wrong value, and return the paths."""
    refused: set[Path] = set()
    for details in error.errors(include_url=False):
        path = tuple(step for step in details["loc"] if step != "[key]")  # pydantic's word
        # An unknown key is one problem, whatever its value.
        if not any(path[:end] in refused for end in range(len(path) + 1)):
            refused.add(path)
            if details["input"] is not UNREADABLE:
                document.refuse(details["msg"], *path)
    return refused


def _without(data: Mapping[str, Any], paths: Container[Path]) -> dict[str, Any]:
    """Return a config without some keys and some keys of groups."""
    return {
        name: {key: child for key, child in value.items() if (name, key) not in paths}
        if isinstance(value, dict)
        else value
        for name, value in data.items()
        if value is not None and (name,) not in paths
    }
