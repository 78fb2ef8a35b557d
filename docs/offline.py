"""Equations as MathML; pictures as AVIF; scripts that the lab's content policy lets run."""

import hashlib
import html
import json
import re
from pathlib import Path

from docutils.nodes import SkipNode
from docutils.utils.math.latex2mathml import tex2mathml
from PIL import Image

_UNUSED = (
    "objects.inv",
    ".buildinfo",
    "genindex.html",
    "py-modindex.html",
    "_static/*.map",
    "_static/**/*.map",
    "_static/skeleton.css",
    "_static/debug.css",
    "_static/basic.css",
    "_static/file.png",
    "_static/minus.png",
    "_static/plus.png",
    "_static/scripts/furo-extensions.js",
)
_WIDEST = 1000  # px; the column of text has 740
_QUALITY = 40
_TAG = re.compile(r"\\tag\{(.+?)\}")  # which docutils does not know
_SIZE = re.compile(r"\\[bB]igg?[lr]?(?![a-zA-Z])")
_INLINE = re.compile(r"<script>(.*?)</script>", re.DOTALL)


def inline_math(writer, node):
    """Write an equation within a line."""
    writer.body.append(_mathml(node, block=False))
    raise SkipNode


def block_math(writer, node):
    """Write an equation of its own."""
    writer.body.append(f'<div class="math">{_mathml(node, block=True)}</div>')
    raise SkipNode


def _mathml(node, *, block):
    tex = _SIZE.sub("", _TAG.sub(r"\\qquad (\1)", node.astext()))
    return tex2mathml(tex, as_block=block)


def slim(app, exception):
    """Rewrite the built files, once there are all of them."""
    if exception is not None or app.builder.format != "html":
        return
    site = Path(app.outdir)
    for pattern in _UNUSED:
        for file in site.glob(pattern):
            file.unlink()
    (site / "_sources").rmdir()
    for file in site.glob("_images/*.png"):
        with Image.open(file) as picture:
            picture.thumbnail((_WIDEST, 10 * _WIDEST))
            picture.convert("RGB").save(file.with_suffix(".avif"), quality=_QUALITY)
        file.unlink()
    for file in site.glob("_downloads/**/*.ipynb"):  # who takes it runs it
        notebook = json.loads(file.read_text())
        for cell in notebook["cells"]:
            cell.update({"outputs": []} if "outputs" in cell else {})
        file.write_text(json.dumps(notebook, ensure_ascii=False, indent=1))
    for page in site.rglob("*.html"):
        text = re.sub(r"(_images/[\w.-]+)\.png", r"\1.avif", page.read_text())
        up = "../" * (len(page.relative_to(site).parts) - 1)
        page.write_text(_INLINE.sub(lambda found, up=up: _as_file(site, up, found[1]), text))


def _as_file(site, up, script):
    """Return a script element whose text is a file, as ``script-src 'self'`` demands."""
    name = f"_static/inline-{hashlib.sha256(script.encode()).hexdigest()[:8]}.js"
    (site / name).write_text(script)
    return f'<script src="{html.escape(up + name)}"></script>'
