"""``python -m motionlab.scene3d``: serves one scene, fed through stdin; ends when that does."""

from __future__ import annotations

import json
import os
import sys
import warnings

import numpy as np

from motionlab.scene3d import protocol


def main() -> None:
    """Report the port, or a failure, on stdout; then show incoming poses."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # viser prints there
    message = protocol.read(sys.stdin.buffer)
    if message is None or message[0] != protocol.START:
        return
    start = protocol.SceneDescription.decode(message[1])
    try:
        from motionlab.scene3d.server import SceneServer  # noqa: PLC0415 - it may not be installed
    except ImportError as error:
        reason = f"viser cannot be loaded: {error.name or 'a module'} cannot be imported"
        print(json.dumps({"error": reason}), file=answers, flush=True)
        return
    # A viewer may disconnect while a message is sent to it.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    # Its messages may hold other types than viser expects, which viser itself reports.
    warnings.filterwarnings("ignore", module=r"viser\.infra\._messages")
    scene = SceneServer(start)
    print(json.dumps({"port": scene.port}), file=answers, flush=True)
    width = protocol.width(len(start.variants))
    forces = (len(start.variants), 2, 2, 3)
    while (message := protocol.read(sys.stdin.buffer)) is not None:
        match message:
            case (protocol.POSES, payload):
                scene.show(np.frombuffer(payload, "<f4").reshape(-1, width))
            case (protocol.FORCES, payload):
                scene.forces = np.frombuffer(payload, "<f4").reshape(forces)
            case (protocol.VIEW, payload):
                scene.configure(*protocol.decode_view(payload))
            case (protocol.CLEAR, _):
                scene.clear()
            case (kind, _):
                raise ValueError(f"a message of kind {kind!r}")
    os._exit(0)  # viser's stop waits for viewers that never read


if __name__ == "__main__":
    main()
