"""A job that ends in an error of the program: it fails, and the log has where."""

from __future__ import annotations

import logging
import time
from pathlib import Path

import pytest
from pydantic import BaseModel

from motionlab.service.jobs import Jobs, Progress
from motionlab.store.records import RecordStore


def test_an_unforeseen_error_fails_the_job_and_is_logged(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    def work(_: Progress) -> BaseModel:
        raise ZeroDivisionError("nobody thought of that")

    jobs = Jobs(at_once=1, waiting_max=1, kept_max=1, records=RecordStore(tmp_path))
    with caplog.at_level(logging.ERROR):
        job = jobs.submit("tune", {}, work)
        while (report := jobs.report(job.id)) is not None and report.state != "failed":
            time.sleep(0.01)
        jobs.close()
    assert report is not None and report.error == "ZeroDivisionError: nobody thought of that"
    (logged,) = caplog.records
    assert logged.exc_info is not None and logged.exc_info[0] is ZeroDivisionError
