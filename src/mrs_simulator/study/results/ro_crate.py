"""A run's directory as an RO-Crate 1.1: what each file is, and what made it, in one file of JSON-LD."""

import datetime
import json
import os

from mrs_simulator.core.writing import write_text
from mrs_simulator.version import __version__

CRATE_FILE = "ro-crate-metadata.json"
CONTEXT, PROFILE = "https://w3id.org/ro/crate/1.1/context", "https://w3id.org/ro/crate/1.1"
UNLICENSED = (
    "None is stated yet: who made the run says how it may be used."  # an RO-Crate needs one
)
PRODUCT, RUN = "#mrs_simulator", "#run"
MEDIA_TYPES = {
    "csv": "text/csv",
    "json": "application/json",
    "yaml": "application/yaml",
    "png": "image/png",
    "pdf": "application/pdf",
    "svg": "image/svg+xml",
}
MEANINGS = {
    "run.csv": "poses and commands of each robot at each sample",
    "run.json": "what else is known of the run: collisions, incidents, warnings",
    "scenario.yaml": "the scenario that was run",
    "verdict.json": "whether theory and run agree, claim by claim",
    "provenance.json": "command, versions, and SHA-256 of what went in and came out",
}


def write_crate(title, names, out):
    """Describe the files ``names`` of the run called ``title`` in the directory ``out``, as its crate."""
    now = datetime.datetime.now(datetime.timezone.utc).replace(microsecond=0).isoformat()
    text = json.dumps({"@context": CONTEXT, "@graph": _graph(title, names, out, now)}, indent=2)
    write_text(os.path.join(out, CRATE_FILE), text + "\n")


def _graph(title, names, out, now):
    files = [{"@id": name} for name in names]
    made = [each for each in files if each["@id"] != "scenario.yaml"]
    about = {
        "@id": CRATE_FILE,
        "@type": "CreativeWork",
        "conformsTo": {"@id": PROFILE},
        "about": {"@id": "./"},
    }
    dataset = {
        "@id": "./",
        "@type": "Dataset",
        "name": title or "A run of mrs_simulator",
        "description": "A run of a multi-robot system, its figures and its verdict",
        "datePublished": now,
        "license": UNLICENSED,
        "hasPart": files,
        "mentions": {"@id": RUN},
    }
    run = {
        "@id": RUN,
        "@type": "CreateAction",
        "name": "mrs-simulator experiment scenario.yaml",
        "endTime": now,
        "instrument": {"@id": PRODUCT},
        "object": {"@id": "scenario.yaml"},
        "result": made,
    }
    product = {
        "@id": PRODUCT,
        "@type": "SoftwareApplication",
        "name": "mrs_simulator",
        "softwareVersion": __version__,
    }
    return [about, dataset, run, product, *(_file(name, out) for name in names)]


def _file(name, out):
    described = {"description": MEANINGS[name]} if name in MEANINGS else {}
    return {
        "@id": name,
        "@type": "File",
        "name": name,
        **described,
        "encodingFormat": MEDIA_TYPES[name.rpartition(".")[2]],
        "contentSize": str(os.path.getsize(os.path.join(out, name))),
    }
