"""The command ``motionlab drive``: drives of a running server."""

from __future__ import annotations

import argparse
import getpass
import json
import sys
import time
from typing import TYPE_CHECKING, Any

from motionlab.errors import DONE, FAILED, ConfigError, FieldError
from motionlab.scripting.http_client import ADDRESS, HeldLease, LabServer, ServerRefused
from motionlab.studies.options import add_json, add_set, set_options, source

if TYPE_CHECKING:
    from collections.abc import Callable

EXAMPLES = """\
examples:
  motionlab drive status
  motionlab drive reset
  motionlab drive run circle --variant B --arm
  motionlab drive tune circle --variant B --axis x
  motionlab drive commission
  motionlab drive commission commutation --confirm
  motionlab drive commission commutation --take
  motionlab drive stop

The server needs --drive; `motionlab docs drive`. stop needs no control: it is for everybody.
"""
_POLL = 0.1  # s
_UP_TIME = 60.0  # s, for drives to come up, to enable, to come to rest
_WRITTEN = 20  # turns of this, until the recording of a short motion has begun
_UNDER_WAY = {"queued", "running"}
_MICRO = 1e6


def add(commands: Any) -> None:
    """Add ``motionlab drive``."""
    parser = commands.add_parser(
        "drive",
        help="show, stop, arm and move the drives of a server",
        description="Show, stop, arm and move the drives of a running server.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    orders = parser.add_subparsers(title="orders", metavar="ORDER", required=True)

    def order(name: str, command: Callable[[argparse.Namespace], int], summary: str) -> Any:
        description = f"{summary[0].upper()}{summary[1:]}."
        added = orders.add_parser(name, help=summary, description=description)
        added.add_argument(
            "--server", metavar="URL", default=ADDRESS, help="the server (default: %(default)s)"
        )
        added.set_defaults(command=command)
        return added

    add_json(order("status", _status, "show link, drives and faults"))
    order("stop", _stop, "brake to rest and switch the torque off; needs no control")
    order("disarm", _disarm, "switch the torque off at once")
    order("reset", _reset, "clear a fault, or bring the drives up again; never arms")
    step = order("commission", _commission, "show the steps of commissioning, or do one")
    step.add_argument("step", metavar="STEP", nargs="?", help="step to do, such as currents")
    meant = step.add_mutually_exclusive_group()
    meant.add_argument(
        "--confirm", action="store_true", help="the mover may move: steps with torque need it"
    )
    meant.add_argument(
        "--take",
        action="store_true",
        help="take the changes that the step has shown, and bring the drives up with them",
    )
    moving = order(
        "arm", _arm, "switch the torque on and hold the position until interrupted, then stop"
    )
    _add_scenario(moving)
    moving = order("run", _run, "carry out one variant of a scenario on the drives, then stop")
    _add_scenario(moving)
    moving.add_argument("--arm", action="store_true", help="switch the torque on before")
    add_json(moving)
    tuning = order("tune", _tune, "tune gains in few motions, asking before each; then stop")
    _add_scenario(tuning)
    tuning.add_argument("--axis", choices=("x", "y"), default="x", help="default: %(default)s")
    tuning.add_argument("--metric", choices=("peak", "rms"), default="peak", help="of the error")
    tuning.add_argument(
        "--response", metavar="RUN", help="identifier of a run of a multisine, for margins"
    )
    tuning.add_argument(
        "--run",
        dest="runs",
        metavar="RUN",
        action="append",
        default=[],
        help="identifier of a motion made before",
    )
    for name, unit, what in (
        ("--error", "M", "largest following error allowed (default: twice the first motion's)"),
        ("--force", "N", "largest force command allowed (default: 90 %% of the limit)"),
        ("--step", "X", "largest factor of a gain from a motion made (default: 1.5)"),
    ):
        tuning.add_argument(name, metavar=unit, type=float, help=what)
    tuning.add_argument("--motions", metavar="N", type=int, help="most motions (default: 20)")


def _add_scenario(parser: Any) -> None:
    parser.add_argument("scenario", metavar="SCENARIO", help="shipped scenario, or a .toml file")
    parser.add_argument("--variant", metavar="NAME", help="which of its variants, such as B")
    add_set(parser, "change a field of it (repeatable)")


def _status(options: argparse.Namespace) -> int:
    status = LabServer(options.server).call("GET", "/drive")
    print(json.dumps(status) if options.json else _in_words(status))
    return FAILED if status["state"] in {"offline", "fault"} else DONE


def _stop(options: argparse.Namespace) -> int:
    status = LabServer(options.server).call("POST", "/drive/stop?by=command%20line")
    print(f"STOP given; the drives were {status['state']}")
    return DONE


def _disarm(options: argparse.Namespace) -> int:
    server = LabServer(options.server)
    with _control(server) as lease:
        print(server.call("POST", "/drive/disarm", headers=lease.headers)["state"])
    return DONE


def _reset(options: argparse.Namespace) -> int:
    server = LabServer(options.server)
    with _control(server) as lease:
        server.call("POST", "/drive/reset", headers=lease.headers)
        problem = _settled(server, {"ready"})
    print(problem or "ready", file=sys.stderr if problem else sys.stdout)
    return FAILED if problem else DONE


def _commission(options: argparse.Namespace) -> int:
    server = LabServer(options.server)
    place = "/drive/commissioning"
    if options.step is None:
        if options.take:
            raise ConfigError(FieldError("STEP", "--take needs the step whose changes it takes"))
        print(_steps_in_words(server.call("GET", place)))
        return DONE
    named = _step(server.call("GET", place), options)
    if options.take:
        return _take(server, f"{place}/{options.step}", named)
    body = {"confirm": True} if options.confirm else None
    with _control(server) as lease:
        # A step with torque, or by hand, only begins with this call.
        server.call("POST", f"{place}/{options.step}", body, lease.headers)
        shown = ""
        while (status := server.call("GET", place))["running"] or status["by_hand"]:
            text = _under_way(status)
            if text != shown:
                print(text, file=sys.stderr, flush=True)
            shown = text
            time.sleep(_POLL)
    step = _step(status, options)
    finding = step["finding"]
    if finding is None:
        print(f"motionlab: {step['title']} was ended", file=sys.stderr)
        return FAILED
    print("\n".join(_finding_in_words(step["title"], finding)))
    if finding["changes"]:
        print(f"motionlab drive commission {options.step} --take takes this, then do it again")
    return DONE if finding["holds"] else FAILED


def _take(server: LabServer, place: str, step: dict[str, Any]) -> int:
    """Take the changes that a step shows, and wait for the drives."""
    changes = step["finding"]["changes"] if step["finding"] else []
    if not changes:
        print(f"motionlab: {step['title']} shows no change to take", file=sys.stderr)
        return FAILED
    with _control(server) as lease:
        server.call("POST", f"{place}/changes", changes, lease.headers)
        for change in changes:
            print("taken: " + _in_figures(change), flush=True)
        problem = _settled(server, {"ready"})
    if problem:
        print(f"motionlab: {problem}", file=sys.stderr)
    return FAILED if problem else DONE


def _step(status: dict[str, Any], options: argparse.Namespace) -> dict[str, Any]:
    """Return the step that was named.

    Raises
    ------
    ConfigError
        If there is no such step.
    """
    names = [each["name"] for each in status["steps"]]
    if options.step not in names:
        raise ConfigError(FieldError("STEP", f"{options.step!r} is none of {', '.join(names)}"))
    return status["steps"][names.index(options.step)]


def _in_figures(change: dict[str, Any]) -> str:
    return f"{change['path']} {change['now']:.10g} -> {change['then']:.10g}"


def _under_way(status: dict[str, Any]) -> str:
    """Return what a step does at the moment."""
    if by_hand := status["by_hand"]:
        x, y = (1e3 * moved for moved in by_hand["moved"])
        return f"x {x:+.2f} mm, y {y:+.2f} mm"
    return status["running"]["text"]


def _steps_in_words(status: dict[str, Any]) -> str:
    """Return the steps, one a line, and the changes that were taken."""
    lines = []
    for number, step in enumerate(status["steps"], start=1):
        text = step["finding"]["text"] if step["finding"] else ""
        torque = "torque" if step["torque"] else ""
        line = f"{number} {step['name']:12} {step['title']:26} {torque:7}{step['state']:8}{text}"
        lines.append(line.rstrip())
    lines += [text for text in (status["damage"], status["other_drives"]) if text]
    if not status["other_drives"]:
        lines += ["taken: " + _in_figures(change) for change in status["record"]["taken"]]
    return "\n".join(lines)


def _finding_in_words(title: str, finding: dict[str, Any]) -> list[str]:
    """Return what a step found, row by row."""
    return [
        f"{title}: {finding['text']}",
        *(
            f"  {'' if row['holds'] else 'NOT '}{row['name']}: {row['found']}"
            f" (expected {row['expected']})"
            for row in finding["rows"]
        ),
        *("  to be taken: " + _in_figures(change) for change in finding["changes"]),
    ]


def _arm(options: argparse.Namespace) -> int:
    server = LabServer(options.server)
    with _control(server) as lease:
        _switch_on(server, lease, _request(options))
        print("holding: Ctrl-C stops, and switches the torque off", flush=True)
        while True:
            status = server.call("GET", "/drive")
            if status["state"] != "holding":
                print(f"motionlab: {_ended(status)}", file=sys.stderr)
                return FAILED
            time.sleep(_POLL)


def _run(options: argparse.Namespace) -> int:
    server = LabServer(options.server)
    request = _request(options)
    with _control(server) as lease:
        if options.arm:
            _switch_on(server, lease, request)
        session, metrics = _move(server, lease, request)
        status = server.call("GET", "/drive")
    done = session["state"] == "finished"
    if options.json:
        print(json.dumps({"run": session["run"], "state": session["state"], **metrics}))
    else:
        print("\n".join([f"run {session['run'] or 'not recorded'}", *_figures(metrics)]))
    if not done:
        print(f"motionlab: {_ended(status)}", file=sys.stderr)
    return DONE if done else FAILED


def _move(
    server: LabServer, lease: HeldLease, request: dict[str, Any]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Carry out one motion; return its session at the end, and its metrics."""
    session = server.call("POST", "/drive/motions", request, lease.headers)
    place = f"/sessions/{session['id']}"
    while (session := server.call("GET", place))["state"] in {"playing", "stopping"}:
        time.sleep(_POLL)
    # The recording of a short motion may begin after its end.
    for _ in range(_WRITTEN):
        if session["run"] is not None:
            break
        time.sleep(_POLL)
        session = server.call("GET", place)
    metrics = server.call("GET", f"{place}/metrics")
    server.call("DELETE", place)
    return session, metrics


def _tune(options: argparse.Namespace) -> int:
    """Tune on the drives: a person agrees to each motion before it is made."""
    from motionlab.studies.safe_tune.documents import SafeTuneDocument
    from motionlab.studies.safe_tune.report import in_words, report

    server = LabServer(options.server)
    if options.variant is None:
        from motionlab.config.load import load_scenario

        options.variant = [*load_scenario(source(options)).variants][:2][-1]
    request = _request(options)
    present: dict[str, Any] = request.get("set", {})
    delay = {f"variants.{options.variant}.controller.delay": 1}  # as it is on drives
    names = ("axis", "metric", "response", "error", "force", "step", "motions")
    search = request | set_options(options, *names) | {"set": present | delay}
    runs = [*options.runs]
    armed = False
    with _control(server) as lease:
        if problem := _settled(server, {"ready", "holding"}):
            raise ServerRefused(problem, "drive-link")
        while True:
            job = server.call("POST", "/safe-tune", search | {"runs": runs})
            while (job := server.call("GET", f"/jobs/{job['id']}"))["state"] in _UNDER_WAY:
                time.sleep(_POLL)
            if job["state"] != "done":
                raise ServerRefused(job["error"] or f"the search was {job['state']}", "safe-tune")
            document = SafeTuneDocument.model_validate(job["result"])
            motion = document.proposal
            if motion is None:
                print(report(document))
                return DONE if document.best is not None else FAILED
            if armed and not document.motions[-1].within:
                server.call("POST", "/drive/stop")  # not held with gains like these
                armed = False
                if problem := _settled(server, {"ready"}):
                    raise ServerRefused(problem, "drive-link")
            print("\n".join([*document.warnings, *in_words(motion)]))
            if not _agreed(len(runs) + 1):
                print(report(document))
                return DONE
            next_motion = request | {"set": present | motion.changes}
            if not armed:
                _switch_on(server, lease, next_motion)
                armed = True
            session, _ = _move(server, lease, next_motion)
            if session["state"] != "finished" or session["run"] is None:
                print(f"motionlab: {_ended(server.call('GET', '/drive'))}", file=sys.stderr)
                return FAILED
            _kept(server, session["run"])
            runs.append(session["run"])
            print(f"run {session['run']}")


def _agreed(number: int) -> bool:
    """Ask whether the mover may move; without anybody to answer it may not."""
    try:
        return input(f"Make motion {number}? [y/N] ").strip().lower() in {"y", "yes"}
    except EOFError:
        return False


def _kept(server: LabServer, run: str) -> None:
    """Wait until a run is complete."""
    deadline = time.monotonic() + _UP_TIME
    while server.call("GET", f"/runs/{run}")["state"] == "recording":
        if time.monotonic() > deadline:
            raise ServerRefused(f"run {run} is still being recorded", "safe-tune")
        time.sleep(_POLL)


def _control(server: LabServer) -> HeldLease:
    return HeldLease(server, f"{getpass.getuser()}, command line"[:40])


def _request(options: argparse.Namespace) -> dict[str, Any]:
    """Return a scenario, its changes and a variant, as the server takes them."""
    from motionlab.config.changes import parse_assignments
    from motionlab.config.load import load_scenario
    from motionlab.config.named_configs import names

    variant = {} if options.variant is None else {"variant": options.variant}
    changes = parse_assignments(options.assignments)
    if options.scenario in names("scenarios"):
        return {"scenario": options.scenario, "set": changes, **variant}
    scenario = load_scenario(source(options), changes)
    return {"scenario": scenario.model_dump(mode="json"), **variant}


def _switch_on(server: LabServer, lease: HeldLease, request: dict[str, Any]) -> None:
    server.call("POST", "/drive/arm", {**request, "confirm": True}, lease.headers)
    if problem := _settled(server, {"holding"}):
        raise ServerRefused(problem, "drive-link")


def _settled(server: LabServer, states: set[str]) -> str:
    """Wait for one of some states; return why it does not come, or nothing."""
    deadline = time.monotonic() + _UP_TIME
    before = ""
    while True:
        status = server.call("GET", "/drive")
        if status["state"] in states and (status["state"] != "ready" or _in_phase(status)):
            return ""
        if status["fault"] or (status["problem"] and status["problem"] == before):
            return _ended(status)
        if time.monotonic() > deadline:
            return f"the drives are still {status['state']}"
        before = status["problem"]
        time.sleep(1.0 if before else _POLL)  # a problem of before goes once the drives are up


def _in_phase(status: dict[str, Any]) -> bool:
    return status["loop"]["phase_locked"]


def _ended(status: dict[str, Any]) -> str:
    """Return why drives do not move."""
    if fault := status["fault"]:
        figures = ""
        if fault["value"] is not None:
            figures = f": {fault['value']:.4g} {fault['unit']}, limit {fault['limit']:.4g}"
        return f"fault 0x{fault['code']:04X}, {fault['name']}{figures}. {fault['remedy']}"
    return status["problem"] or f"stopped; the drives are {status['state']}"


def _in_words(status: dict[str, Any]) -> str:
    kind = "virtual drive" if status["virtual"] else "drives"
    loop = status["loop"]
    lines = [
        f"{status['title']} ({kind}): {status['state']}",
        f"control: {status['holder'] or 'no one'}",
    ]
    if status["fault"] or status["problem"]:
        lines.append(_ended(status))
    if status["other_drives"]:
        lines.append(f"cannot be armed: {status['other_drives']}")
    if status["age"] is None:
        return "\n".join([*lines, "nothing is known of the drives yet"])
    if not status["known"]:
        lines.append(f"what the drives do is not known; as last known, {status['age']:.1f} s ago:")
    lines += [
        f"  {each['axis']} {each['phase']}  {each['state']:24} 0x{each['status_word']:04X}"
        f"  {each['current']:7.3f} A  {each['error_name']}".rstrip()
        for each in status["drives"]
    ]
    lines += [
        f"  {each['axis']}  {1e3 * each['position']:10.4f} mm, following error "
        f"{_MICRO * each['following_error']:.3g} um"
        for each in status["axes"]
    ]
    lines.append(
        f"loop: {loop['cycles']} cycles, {loop['late']} late, {loop['missed']} without an answer"
    )
    return "\n".join(lines)


def _figures(metrics: dict[str, Any]) -> list[str]:
    """Return the main metrics of a motion."""
    lines = []
    for name, variant in metrics["variants"].items():
        for axis, figures in variant["axes"].items():
            shown = [
                ("max abs following error", "max_abs_following_error", _MICRO, "um"),
                ("RMS following error", "rms_following_error", _MICRO, "um"),
                ("RMS current", "rms_current", 1.0, "A"),
            ]
            lines += [
                f"  {name} {axis}  {title:25} {factor * figures[key]:8.3g} {unit}"
                if figures[key] is not None
                else f"  {name} {axis}  {title:25} not measured"
                for title, key, factor, unit in shown
            ]
    return lines
