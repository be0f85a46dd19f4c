"""What is said of words on the command line that mean nothing: what was expected, or what was probably meant."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from cyclopts import CycloptsError, MissingArgumentError, UnknownOptionError
from cyclopts.exceptions import CoercionError, UnusedCliTokensError

from ..errors import SettingsError, near_miss, one_line
from ..methods.registry import registry
from ..passes.denoise import FILTERS
from ..pipeline.settings import Settings, Shading
from .tokens import parse_share

MEANT: Mapping[str, str] = {
    "--width": "--size WIDTHxHEIGHT", "--height": "--size WIDTHxHEIGHT", "--resolution": "--size WIDTHxHEIGHT",
    "--fov": "--yfov-deg DEGREES (of the height)", "--quality": "--preset NAME", "--no-blur": "--blur none", "--filter": "--blur NAME",
    "--provider": "--gl NAME", "--gpu": "--gl NAME", "--device": "--gl NAME", "--backend": "--gl NAME", "--bg": "--background COLOR",
    "--position": "--eye X,Y,Z", "--lookat": "--target X,Y,Z", "--file": "-o FILE", "-help": "--help", "-?": "--help",
    "-V": "--version", "version": "--version",
}  # fmt: skip
"""Other programs' names -> ours."""

GLOBAL = ("--help", "-h", "--help-all", "--version", "--verbose", "-v", "--quiet", "-q", "--install-completion")
"""Options that need no command."""
NUMBERS = {float: "a number", int: "a whole number"}


def check_command(words: Sequence[str], commands: Sequence[str]) -> None:
    """Raise SettingsError when the first word, after options of all commands, is no command."""
    first = next((word for word in words if word not in ("-v", "--verbose", "-q", "--quiet")), None)
    if first is None or first in commands or first in GLOBAL:
        return
    if Path(first).suffix and not first.startswith("-"):
        raise SettingsError(f"unknown command '{first}'. Did you mean 'ssao-gl render {one_line(' '.join(words), 120)}'?")
    if first.startswith("-"):
        guess = _meant(first) or near_miss(first, GLOBAL)
        raise SettingsError(
            f"unknown option {first}; options stand behind a command, as in: ssao-gl render model.glb -o a.png.{guess}"
        )
    guess = _meant(first) or near_miss(first, commands)
    raise SettingsError(f"unknown command '{first}'; there are {', '.join(commands)}.{guess}")


def explained(error: CycloptsError) -> str:
    """Return one line for what the parser of the command line refuses."""
    command = " ".join(["ssao-gl", *(error.command_chain or ["COMMAND"])])
    match error:
        case UnknownOptionError():
            name = error.token.keyword or error.token.value
            return f"unknown option {name}.{_option_meant(name, error)}  ({command} -h lists all)"
        case MissingArgumentError():
            return _missing(error, command)
        case CoercionError(token=token) if token is not None and error.target_type in NUMBERS:
            share = parse_share(token.value)
            like = "" if share is None else f", like {share:g}"
            return f"{token.keyword or ''} {token.value}: must be {NUMBERS[error.target_type]}{like}".strip()
        case UnusedCliTokensError():
            words = " ".join(error.unused_tokens or [])
            return (
                f"'{one_line(words, 120)}': too many words. The output is named by -o, numbers of one option are joined by commas,"
                f" settings are KEY=VALUE  ({command} -h lists all)"
            )
    return f"{one_line(error)}  ({command} -h lists all)"


def _missing(error: MissingArgumentError, command: str) -> str:
    argument = error.argument
    if argument is None:
        return one_line(error)
    text = str(argument.parameter.help or "").split(" [default")[0].rstrip(".")
    what = f": {text}" if text else ""
    given = error.keyword or next((token.keyword for token in argument.tokens if token.keyword), None)
    if given:
        return f"{given} needs a value{what}"
    name = argument.name if text else argument.name.lstrip("-").upper()  # what has a place is told of in the docstring
    return f"{name} is needed{what}  ({command} -h lists all)"


def _option_meant(name: str, error: UnknownOptionError) -> str:
    known = [option for argument in error.argument_collection for option in argument.names if option.startswith("--")]
    key = name.lstrip("-").replace("-", "_")
    ways = dict.fromkeys(prefix + key for prefix, fields in _settings() if key in fields)
    if ways and "--set" in known and name not in MEANT:
        return f" It is a setting: {' or '.join(f'--set {way}=VALUE' for way in ways)}."
    bare = {option.lstrip("-"): option for option in (*known, *(option for option in GLOBAL if option.startswith("--")))}
    return _meant(name) or near_miss(name.lstrip("-"), bare, 0.65).replace("'", "'--", 1)


def _meant(name: str) -> str:
    return f" Did you mean '{MEANT[name]}'?" if name in MEANT else ""


def _settings() -> Iterator[tuple[str, set[str]]]:
    """Yield the names of all settings, by what stands before them in ``--set``."""
    groups = [*((kind, "") for kind in (*registry().values(), Settings)), *((kind, "blur.") for kind in FILTERS.values())]
    for kind, prefix in (*groups, (Shading, "shading.")):
        yield prefix, {field.name for field in dataclasses.fields(kind) if "limits" in field.metadata}
