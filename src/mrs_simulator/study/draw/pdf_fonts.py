"""Fonts in PDF files: what most figures show of a font is cut out of it once, not for each file anew."""

import contextlib
import functools
import io
import os
import string

# What a file carries of each font, beside what it alone shows; of slanted fonts, what formulas show.
UPRIGHT = frozenset(string.ascii_letters + string.digits + "[]()./=-\N{MINUS SIGN}")
SLANTED = frozenset("PTVehptvxyz\N{GREEK SMALL LETTER ALPHA}\N{GREEK SMALL LETTER OMEGA}")


@contextlib.contextmanager
def shared():
    """Within it, PDF files that show no more than the usual characters of a font carry the same part of it.

    For matplotlib before 3.5 and from 3.9 on, which cut fonts by other functions, nothing is shared.
    """
    from matplotlib.backends import _backend_pdf_ps as fonts

    cut = getattr(fonts, "get_glyphs_subset", None)
    if cut is None or hasattr(fonts, "font_as_file"):
        yield
        return

    def shared_part(path, characters):
        usual = SLANTED if "Italic" in os.path.basename(path) else UPRIGHT
        return io.BytesIO(_part(cut, path, "".join(sorted(usual.union(characters)))))

    fonts.get_glyphs_subset = shared_part
    try:
        yield
    finally:
        fonts.get_glyphs_subset = cut


@functools.lru_cache(maxsize=16)
def _part(cut, path, characters):
    """Return the font of ``path`` with its ``characters`` alone, as bytes of a font file."""
    return cut(path, characters).getvalue()
