"""What was found, typed: attributes in the code, keys of the JSON file for whoever reads it as plain data."""

import json
import math
from collections.abc import Iterator, Mapping
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, ValidationError

from ehamj.errors import InputError


def finite(value: float) -> float | None:
    """A number as JSON has it: None where it is not finite."""
    return float(value) if math.isfinite(value) else None


class Finding(BaseModel, Mapping[str, Any]):
    """Base of everything that a summary holds: frozen, finite numbers (null where undefined), no unknown keys.

    It also reads like the dictionary that it becomes: ``found["peak_hz"]``, ``found.get("failure")``. A field that was
    never set is no key.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True, allow_inf_nan=False, populate_by_name=True)

    def _names(self) -> dict[str, str]:
        """Attribute of each key."""
        fields = type(self).model_fields
        return {field.alias or name: name for name, field in fields.items() if name in self.model_fields_set}

    def __getitem__(self, key: str) -> Any:
        value = getattr(self, self._names()[key])
        return list(value) if isinstance(value, tuple) else value

    def __iter__(self) -> Iterator[str]:  # type: ignore[override]
        return iter(self._names())

    def __len__(self) -> int:
        return len(self._names())

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Finding):
            other = other.to_dict()
        return self.to_dict() == other

    def to_dict(self) -> dict[str, Any]:
        """As plain data, ready for JSON."""
        return self.model_dump(mode="json", by_alias=True, exclude_unset=True)

    def changed(self, **entries: Any) -> Self:
        """A copy with other entries, by key."""
        return type(self).model_validate({**self.to_dict(), **entries})

    @classmethod
    def read(cls, plain: Any, whose: str) -> Self:
        """From plain data, as JSON has it: a text is no number.

        Args:
            plain: what `to_dict` gave.
            whose: where it comes from, for the message.

        Raises:
            InputError: if a key is missing, unknown, or of another type.
        """
        try:
            return cls.model_validate_json(json.dumps(plain), strict=True)
        except ValidationError as error:
            first = error.errors()[0]
            key = ".".join(map(str, first["loc"]))
            said = {"missing": "is missing", "extra_forbidden": "is no key of it"}
            raise InputError(f"{whose}: {key or 'the whole'}: {said.get(first['type'], first['msg'])}") from None
