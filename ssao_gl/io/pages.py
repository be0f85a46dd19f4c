"""HTML pages from templates, which escape whatever is put into them."""

from __future__ import annotations

from typing import Any


def page(package: str, template: str, **values: Any) -> str:
    """Return the page of a template in the folder ``web`` of a package; it may use those of this room, too.

    Whatever values hold is escaped, but for what a template marks as safe. Templates are checked for undefined names.
    """
    from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

    loader = ChoiceLoader([PackageLoader(package, "web"), PackageLoader(__package__, "web")])
    environment = Environment(
        loader=loader,
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template(template).render(**values)
