"""Docstrings are written for Sphinx in small things; here their roles become Markdown."""

import re
from typing import Any

import griffe

_ROLE = re.compile(r":(?!math)[a-z]+:`~?([^`]+)`")
_FLAG = re.compile(r" +# doctest: \+SKIP")
_SESSION = re.compile(r"^>>> .*\n?(?:(?:>>>|\.\.\.)(?: .*)?\n?)*", re.MULTILINE)
_MATH = re.compile(r":math:`([^`]+)`")
_DISPLAY = re.compile(r"^\.\. math::(.*(?:\n(?: +.*|$))*)", re.MULTILINE)


def _as_code(session: re.Match[str]) -> str:
    lines = (line[4:] for line in session[0].rstrip().splitlines())
    return "\n".join(["```python", *lines, "```", ""])


def as_markdown(text: str) -> str:
    """Return a docstring with Sphinx's roles and formulas as Markdown has them."""
    text = _SESSION.sub(_as_code, _FLAG.sub("", text))
    text = _ROLE.sub(lambda m: f"``{m[1]}``", text)
    text = _MATH.sub(lambda m: f"${m[1]}$", text)
    return _DISPLAY.sub(lambda m: "$$\n" + " ".join(m[1].split()) + "\n$$\n\n", text)


class Roles(griffe.Extension):
    """Extension of griffe."""

    def on_instance(self, *, obj: griffe.Object, **_: Any) -> None:
        """Rewrite a docstring before it is read."""
        if obj.docstring is not None:
            obj.docstring.value = as_markdown(obj.docstring.value)
