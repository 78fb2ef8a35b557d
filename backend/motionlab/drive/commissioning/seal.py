"""The seal of a commissioning document: which server found it, and that nothing was changed."""

from __future__ import annotations

import hashlib
import hmac
import json
import secrets
from pathlib import Path

from motionlab.drive.commissioning.record import CommissioningRecord
from motionlab.files import opened, replace

_KEY_BYTES = 32


def read_key(path: Path) -> bytes | None:
    """Return the key of a file; None where there is none.

    Raises
    ------
    OSError
        If it cannot be read.
    """
    try:
        with opened(path) as file:
            key = file.read(_KEY_BYTES + 1)
    except FileNotFoundError:
        return None
    return key if len(key) == _KEY_BYTES else None


def make_key(path: Path) -> bytes:
    """Write a new key to a file, for its owner alone, and return it.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    key = secrets.token_bytes(_KEY_BYTES)
    replace(path, key)
    return key


def sealed(record: CommissioningRecord, key: bytes) -> CommissioningRecord:
    """Return a document with its seal."""
    return record.model_copy(update={"seal": _seal(record, key)})


def holds(record: CommissioningRecord, key: bytes | None) -> bool:
    """Return whether a document is as it was sealed with this key."""
    return key is not None and hmac.compare_digest(record.seal, _seal(record, key))


def _seal(record: CommissioningRecord, key: bytes) -> str:
    """Return the HMAC-SHA256 of a document without its seal, whatever the order of its keys."""
    document = record.model_dump(mode="json", exclude={"seal"})
    canonical = json.dumps(document, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hmac.new(key, canonical.encode(), hashlib.sha256).hexdigest()
