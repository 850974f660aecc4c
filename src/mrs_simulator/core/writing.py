"""Writing files on disks that may be full: errors name the file, and nothing is left half written."""

import contextlib
import functools
import io
import itertools
import os
import sys
import time

FLUSH_PERIOD = 0.2  # [s] of wall time; a program that is killed loses no more than this
AT_ONCE = 1 << 16  # [bytes] written by one call: larger ones make the system hand out new memory
RETRY_PERIOD = 1.0  # [s] of wall time between two tries to write to a full disk
MOST_PRINTED = 1000  # [-] characters of what a law prints while it is asked or run again and again
MOST_PENDING = 1 << 23  # [bytes] kept in memory until there is room again
READER_GONE = 141  # exit code, as of programs that a closed pipe ends
UNWRITABLE = 2  # exit code


@contextlib.contextmanager
def naming(path):
    """Give an ``OSError`` that names no file, as that of a full disk, the name ``path``."""
    try:
        yield
    except OSError as error:
        if error.filename is not None:
            raise
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error


def printing(main):
    """Decorate the ``main`` of a program so that it ends where its standard output cannot be written.

    Silently where the reader has gone, as ``head`` does, else with one line.
    """

    @functools.wraps(main)
    def printed(*arguments, **named):
        if isinstance(sys.stdout, _Output):  # a program within another, which sees to it
            return main(*arguments, **named)
        output, sys.stdout = sys.stdout, _Output(sys.stdout)
        try:
            try:
                return main(*arguments, **named)
            finally:
                sys.stdout.end()
        except OSError:
            failed = sys.stdout.failed
            if failed is None:
                raise
            _give_up(output)
            if isinstance(failed, BrokenPipeError):
                sys.exit(READER_GONE)
            print("standard output: {}".format(failed.strerror), file=sys.stderr)
            sys.exit(UNWRITABLE)
        finally:
            sys.stdout = output

    return printed


def is_of_output(error):
    """Return whether ``error`` is that of a failed write to standard output, which ``printing`` reports."""
    return error is getattr(sys.stdout, "failed", None)


class Limited(io.TextIOBase):
    """A stream that passes the first characters on to standard output, and then says that there is more.

    ``left``: whose ``value`` is how many; processes may share it.
    """

    def __init__(self, left):
        self._left = left

    def write(self, text):
        with getattr(self._left, "get_lock", contextlib.nullcontext)():
            left = self._left.value
            self._left.value = max(0, left - len(text))
        if left > 0:
            shown = text if len(text) < left else text[:left] + "\n[more is not shown]\n"
            # as the process may be killed any time
            print(shown, end="", file=sys.__stdout__, flush=True)
        return len(text)


class Forgiving(io.TextIOBase):
    """A stream that passes on what there is room for: a log on a full disk ends no program."""

    def __init__(self, stream):
        self._stream = stream

    def write(self, text):
        with contextlib.suppress(OSError):
            self._stream.write(text)
        return len(text)

    def flush(self):
        with contextlib.suppress(OSError):
            self._stream.flush()

    def fileno(self):
        return self._stream.fileno()


class _Output:
    """A stream that keeps the error of a failed write."""

    def __init__(self, stream):
        self._stream, self.failed = stream, None

    def __getattr__(self, name):
        return getattr(self._stream, name)

    def write(self, text):
        return self._tried(self._stream.write, text)

    def flush(self):
        return self._tried(self._stream.flush)

    def end(self):
        """Flush; raise the error of a write that failed before, which argparse does not report."""
        self.flush()
        if self.failed is not None:
            raise self.failed

    def _tried(self, function, *arguments):
        try:
            return function(*arguments)
        except OSError as error:
            self.failed = error
            raise


def _give_up(stream):
    """Discard what is written to ``stream``, and what it still holds."""
    with contextlib.suppress(io.UnsupportedOperation), open(os.devnull, "wb") as nowhere:
        os.dup2(nowhere.fileno(), stream.fileno())


def write_text(path, text):
    """Write ``text`` to ``path``, whole or not at all; an ``OSError`` names the file."""
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path, content):
    """Write ``content`` to ``path``, whole or not at all; an ``OSError`` names the file."""
    if os.path.exists(path) and not os.path.isfile(path):  # a pipe or a device
        with naming(path), open(path, "wb") as file:
            file.write(content)
        return
    partial = str(path) + ".part"
    try:
        with naming(path), open(partial, "wb") as file:
            file.write(content)
        os.replace(partial, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.remove(partial)
        raise


class Blocks:
    """Appends blocks of lines to a new file; a full disk neither raises nor leaves half a block.

    Blocks that find no room wait in memory, up to ``MOST_PENDING`` bytes of them; then new ones are
    lost.  ``trouble`` says why the newest are not in the file yet, "" if they are; ``lost`` counts
    blocks that never will be.
    """

    def __init__(self, path, header):
        """Open ``path`` and write ``header``; an ``OSError`` names the file."""
        self.path, self.trouble, self.lost = path, "", 0
        self._pending, self._size = [], 0
        self._whole = 0  # [bytes] of whole blocks in the file
        self._due = 0.0  # [s] of wall time
        with naming(path):
            self._file = open(path, "wb", buffering=0)
            try:
                self._put(_encoded([header]))
            except OSError:
                self._file.close()
                raise

    @property
    def is_due(self):
        """Return whether what is added now is written at once."""
        return time.monotonic() >= self._due

    def add(self, *blocks):
        """Append ``blocks``, each a list of texts that make whole lines together, at once or soon."""
        for block in blocks:
            if self._size > MOST_PENDING and self.trouble:
                self.lost += 1
            else:
                self._pending.append(block)
                self._size += _size(block)
        if self.is_due or (self._size > AT_ONCE and not self.trouble):
            self.flush()

    def extend(self, content, ends):
        """Append blocks at once: ``content``, bytes that may change afterwards, up to each of ``ends``."""
        if self._pending:
            self.flush()
        if not self.trouble:
            with contextlib.suppress(OSError):  # there may be room for some of them
                self._put([content])
                self._due = time.monotonic() + FLUSH_PERIOD
                return
        for begin, end in zip((0, *ends), ends):
            self.add([str(content[begin:end], "utf-8")])

    def flush(self):
        """Write what waits, as far as there is room."""
        done = 0
        try:
            if not self.trouble:
                with contextlib.suppress(OSError):  # there may be room for some of them
                    self._put(_encoded(itertools.chain.from_iterable(self._pending)))
                    done = len(self._pending)
            for block in self._pending[done:]:
                self._put(_encoded(block))
                done += 1
        except OSError as error:
            self.trouble = error.strerror or str(error)
        else:
            self.trouble = ""
        del self._pending[:done]
        self._size = sum(map(_size, self._pending))
        self._due = time.monotonic() + (RETRY_PERIOD if self.trouble else FLUSH_PERIOD)

    def close(self):
        """Write what waits, once more, and close the file; closing twice does no harm."""
        if self._file.closed:
            return
        self.flush()
        self.lost += len(self._pending)
        self._pending, self._size = [], 0
        with contextlib.suppress(OSError):
            self._file.close()

    def _put(self, contents):
        """Append ``contents``, bytes, whole or not at all."""
        size = 0
        try:
            for content in contents:
                rest = memoryview(content)
                while rest:
                    rest = rest[self._file.write(rest) :]
                size += len(content)
        except OSError:
            os.ftruncate(self._file.fileno(), self._whole)
            self._file.seek(self._whole)
            raise
        self._whole += size


def _size(block):
    return sum(map(len, block))


def _encoded(texts):
    """Yield ``texts`` as bytes, small ones together."""
    together, size = [], 0
    for text in texts:
        together.append(text)
        size += len(text)
        if size >= AT_ONCE:
            yield "".join(together).encode("utf-8")
            together, size = [], 0
    yield "".join(together).encode("utf-8")
