"""Formulas as MathML, made when the pages are built: browsers show it without a script."""

import html
import re

from latex2mathml.converter import convert

_INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.DOTALL)
_BLOCK = re.compile(r'<div class="arithmatex">\s*\\\[(.*?)\\\]\s*</div>', re.DOTALL)


def on_page_content(content: str, **_: object) -> str:
    """Replace what ``pymdownx.arithmatex`` leaves for a script."""
    content = _INLINE.sub(lambda m: convert(html.unescape(m[1])), content)
    return _BLOCK.sub(lambda m: convert(html.unescape(m[1]), display="block"), content)
