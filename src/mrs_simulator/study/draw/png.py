"""PNG files of drawings: the pixels and the texts that matplotlib writes, in half the time."""

import struct
import zlib

import matplotlib
import numpy as np

SIGNATURE = b"\x89PNG\r\n\x1a\n"
OF_RGBA = 8, 6, 0, 0, 0  # bits, kind of colour, compression, filters, no interlacing
SOFTWARE = "Matplotlib version{}, https://matplotlib.org/"
INCH = 0.0254  # [m]
METRE = 1  # a unit, in the file's code


def png(pixels, dpi, texts):
    """Return the bytes of a PNG file of ``pixels`` (height, width, 4), bytes of red, green, blue and alpha.

    ``texts``: what the file carries by name, in latin-1.  Rows are compressed as they are: to choose a
    filter for each, as Pillow does, takes longer than to compress them, and makes drawings of lines larger.
    """
    height, width, _ = pixels.shape
    rows = np.zeros((height, 1 + 4 * width), dtype=np.uint8)  # each begins with its filter: none
    rows[:, 1:] = pixels.reshape(height, -1)
    texts = {"Software": SOFTWARE.format(matplotlib.__version__), **texts}
    dots = int(dpi / INCH + 0.5)
    return b"".join(
        (
            SIGNATURE,
            _chunk(b"IHDR", struct.pack(">2I5B", width, height, *OF_RGBA)),
            *(_chunk(b"tEXt", "\0".join(each).encode("latin-1")) for each in texts.items()),
            _chunk(b"pHYs", struct.pack(">2IB", dots, dots, METRE)),
            _chunk(b"IDAT", zlib.compress(rows)),
            _chunk(b"IEND", b""),
        )
    )


def _chunk(kind, content):
    check = zlib.crc32(content, zlib.crc32(kind))
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", check)
