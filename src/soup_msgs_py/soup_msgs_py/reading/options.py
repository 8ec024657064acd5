"""The options of a policy, checked against the constructor that takes them, before anything starts."""

from __future__ import annotations

import inspect
import json
import typing
from collections.abc import Callable, Mapping
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, PydanticSchemaGenerationError, PydanticUserError, ValidationError
from pydantic import create_model as pydantic_model

from soup_msgs_py.reading.yaml_input import first_problem

_BY_NAME = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)


def check_options(make: Callable[..., object], options: Mapping[str, Any], source: object, key: str) -> dict[str, Any]:
    """The options as the constructor's annotations have them: a number is one, and finite, a list may be a tuple.

    What has no annotation may be anything. Bounds are said in the annotation: `Annotated[float, Field(ge=0)]`.

    Args:
        make: A class, or whatever takes the options as keyword arguments.
        options: By name.
        source: For messages: where they were chosen.
        key: For messages: the key that they stand under.

    Raises:
        InputError: An option is unknown, is missing, or its value does not fit.
    """
    model = _model(make)
    try:
        # from JSON a list becomes the tuple, and a text the enumeration, that is asked for; nothing else is guessed
        checked = model.model_validate_json(json.dumps(options))
    except ValidationError as error:
        raise first_problem(model, error, dict(options), source, prefix=key) from error
    except (TypeError, ValueError):  # a value that only Python or YAML has
        try:
            checked = model.model_validate(dict(options))
        except ValidationError as error:
            raise first_problem(model, error, dict(options), source, prefix=key) from error
    given = {field.alias or name: getattr(checked, name) for name, field in _given(checked)}
    return {**given, **(checked.model_extra or {})}


def _given(checked: BaseModel) -> list[tuple[str, Any]]:
    """The fields that were given, others keep the constructor's own defaults."""
    return [(name, field) for name, field in type(checked).model_fields.items() if name in checked.model_fields_set]


def _model(make: Callable[..., object]) -> type[BaseModel]:
    """A model with one field for each option; its alias is the option's name, which may be any."""
    parameters = inspect.signature(make).parameters.values()
    takes_all = any(parameter.kind is inspect.Parameter.VAR_KEYWORD for parameter in parameters)
    config = ConfigDict(
        extra="allow" if takes_all else "forbid", strict=True, allow_inf_nan=False, arbitrary_types_allowed=True
    )
    hints = _hints(make)
    fields: dict[str, Any] = {}
    without_hints: dict[str, Any] = {}
    for number, parameter in enumerate(parameters):
        if parameter.kind in _BY_NAME:
            default = ... if parameter.default is inspect.Parameter.empty else parameter.default
            field = Field(default, alias=parameter.name, validate_default=False)
            fields[f"option_{number}"] = (hints.get(parameter.name, Any), field)
            without_hints[f"option_{number}"] = (Any, field)
    try:
        return pydantic_model("Options", __config__=config, **fields)
    except (PydanticSchemaGenerationError, PydanticUserError, TypeError):  # of annotations that nothing can be told by
        return pydantic_model("Options", __config__=config, **without_hints)


def _hints(make: Callable[..., object]) -> dict[str, Any]:
    try:
        return typing.get_type_hints(make.__init__ if isinstance(make, type) else make, include_extras=True)
    except Exception:  # an annotation is a person's own code, and may name what is not there
        return {}
