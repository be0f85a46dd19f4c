"""Where results of rays are kept on the command line, for those that take long and go on where they were cut."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from .help_pages import OUTPUT
from .output import cache_folder


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class CacheOptions:
    """The folder of results, or none."""

    cache: Annotated[
        Path | None,
        Parameter(
            negative="",
            help="Folder where results are kept and interrupted runs go on. [default: the user's cache folder]",
        ),
    ] = None
    no_cache: Annotated[bool, Parameter(negative="", help="Keep nothing and take nothing from there.")] = False

    def folder(self) -> Path | None:
        """Return the folder, None for none. Raises FormatError for one that cannot be written."""
        return None if self.no_cache else cache_folder(self.cache)
