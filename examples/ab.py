"""Compare two gains of B on the circle over REST: start ``make run``, then run this."""

import json
import os
from urllib.request import Request, urlopen

SIMULATE = os.environ.get("LAB", "http://127.0.0.1:8000") + "/api/v1/simulate"


def simulate(**changes: float) -> dict:
    """Return the comparison of B with A after changes of dotted paths, SI."""
    body = json.dumps({"scenario": "circle", "set": changes}).encode()
    with urlopen(Request(SIMULATE, body, {"Content-Type": "application/json"})) as answer:
        return json.load(answer)["comparison"]


for k_p in (200300.0, 400000.0):
    ratio = simulate(**{"variants.B.controller.x.k_p": k_p})["x"]["max_abs_following_error_ratio"]
    print(f"k_p = {k_p / 1000:g} N/mm: B's largest error on x is {ratio:.1%} of A's")
