"""The column ``kind`` of ``run.csv``, the only one of texts."""

import csv


def kind_fields(kinds):
    """Return the names of ``kinds`` as fields of a line: quoted where they need it, without line ends."""
    return [_field(" ".join(name.split())) for name in kinds]


def _field(name):
    if '"' in name or "," in name:
        return '"{}"'.format(name.replace('"', '""'))
    return name


def without_kinds(lines):
    """Return ``lines`` without their last field, and these fields; ``ValueError`` if one has none."""
    if any('"' in line for line in lines):
        rows = [_quoted_row(line) for line in lines]
        return [",".join(row[:-1]) for row in rows], [row[-1] for row in rows]
    parts = [line.rstrip("\n").rpartition(",") for line in lines]
    return [head for head, _, _ in parts], [kind for _, _, kind in parts]


def _quoted_row(line):
    try:
        return next(csv.reader([line]))
    except (csv.Error, StopIteration) as error:
        raise ValueError(str(error)) from None
