"""``python -m motionlab.scene``: serves one scene, fed through stdin; ends when that does."""

from __future__ import annotations

import json
import os
import sys
import warnings

import numpy as np

from motionlab.scene import feed


def main() -> None:
    """Answer with the port, or why there is none, on stdout; then show what comes."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # viser prints there
    told = feed.read(sys.stdin.buffer)
    if told is None or told[0] != feed.START:
        return
    start = feed.Start.decode(told[1])
    try:
        from motionlab.scene.server import SceneServer  # noqa: PLC0415 - it may not be installed
    except ImportError as error:
        reason = f"viser cannot be loaded: {error.name or 'a module'} cannot be imported"
        print(json.dumps({"error": reason}), file=answers, flush=True)
        return
    # A viewer may leave while it is being told something.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    # What it says may be of other types than viser expects, which comes to light by itself.
    warnings.filterwarnings("ignore", module=r"viser\.infra\._messages")
    scene = SceneServer(start)
    print(json.dumps({"port": scene.port}), file=answers, flush=True)
    width = feed.width(len(start.variants))
    while (message := feed.read(sys.stdin.buffer)) is not None:
        match message:
            case (feed.POSES, payload):
                scene.show(np.frombuffer(payload, "<f4").reshape(-1, width))
            case (feed.CLEAR, _):
                scene.clear()
            case (kind, _):
                raise ValueError(f"a message of kind {kind!r}")
    os._exit(0)  # viser's stop waits for viewers that never read


if __name__ == "__main__":
    main()
