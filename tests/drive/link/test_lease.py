"""The lease: one holder, kept by a heartbeat."""

from __future__ import annotations

import pytest

from motionlab.drive import lease as module
from motionlab.drive.lease import Lease, NotHeld


def test_one_holder_at_a_time_by_its_token() -> None:
    lease = Lease()
    with pytest.raises(NotHeld, match="no one controls the drives"):
        lease.check("")
    token = lease.take("Ada")
    lease.check(token)
    with pytest.raises(NotHeld, match="'Ada' controls the drives"):
        lease.take("Bob")
    with pytest.raises(NotHeld, match="'Ada' controls the drives"):
        lease.check(token + "x")


def test_without_a_heartbeat_it_expires_but_is_not_free(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: clock[0])
    lease = Lease()
    token = lease.take("Ada")
    clock[0] += module.SECONDS - 0.1
    assert not lease.expired
    lease.renew(token)
    clock[0] += module.SECONDS
    assert lease.expired
    with pytest.raises(NotHeld):  # what it moved may not have come to rest yet
        lease.take("Bob")
    lease.free()
    assert lease.take("Bob") != token


def test_given_up_it_ends_at_once() -> None:
    lease = Lease()
    lease.take("Ada")
    lease.end()
    assert lease.expired
