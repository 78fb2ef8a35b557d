"""Run A, then B on the drives of a server, and compare them: docs/drive.md."""

import json
import os
import threading
import time
from urllib.request import Request, urlopen

API = os.environ.get("LAB", "http://127.0.0.1:8000") + "/api/v1"
CIRCLE = {"scenario": "circle", "set": json.loads(os.environ.get("CHANGES", "{}"))}


def call(method: str, path: str, body: dict | None = None, lease: str = "") -> dict:
    """Return the answer to a call."""
    headers = {"Content-Type": "application/json", "Lease": lease}
    data = None if body is None else json.dumps(body).encode()
    with urlopen(Request(API + path, data, headers, method=method)) as answer:
        return json.loads(answer.read() or "{}")


def wait_for(path: str, *states: str) -> dict:
    """Wait for a state of the drives, or of a session."""
    while (found := call("GET", path))["state"] not in states:
        time.sleep(0.1)
    return found


def keep(lease: str, over: threading.Event) -> None:
    """Keep control: it ends 2 s after the last heartbeat, and what moves is stopped."""
    while not over.wait(0.5):
        call("PUT", "/drive/lease", lease=lease)


lease = call("POST", "/drive/lease", {"holder": "drive_ab.py"})["lease"]
over = threading.Event()
threading.Thread(target=keep, args=(lease, over), daemon=True).start()
try:
    call("POST", "/drive/arm", CIRCLE | {"variant": "A", "confirm": True}, lease)
    for variant in "AB":
        wait_for("/drive", "holding")
        session = call("POST", "/drive/motions", CIRCLE | {"variant": variant}, lease)
        ended = wait_for(f"/sessions/{session['id']}", "finished", "stopped")
        metrics = call("GET", f"/sessions/{session['id']}/metrics")["variants"][variant]
        error = metrics["axes"]["x"]["max_abs_following_error"]
        print(f"{variant} {ended['state']}: largest error on x {1e6 * error:.1f} um")
finally:
    over.set()
    call("DELETE", "/drive/lease", lease=lease)  # armed drives stop
