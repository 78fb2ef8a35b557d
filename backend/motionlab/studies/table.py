"""All studies, in the order of the command line's help."""

from __future__ import annotations

from motionlab.paper.study import ReproduceStudy
from motionlab.studies.identify.study import IdentifyStudy
from motionlab.studies.learn.study import LearnStudy
from motionlab.studies.loop.study import FrequencySweepStudy
from motionlab.studies.maps import MapStudy
from motionlab.studies.montecarlo.study import MonteCarloStudy
from motionlab.studies.platform import PlatformStudy
from motionlab.studies.sharing.study import SharingStudy
from motionlab.studies.sizing import SizingStudy
from motionlab.studies.study import Study
from motionlab.studies.sweep.study import SweepStudy
from motionlab.studies.tune.study import LandscapeStudy, TuneStudy
from motionlab.studies.why.study import WhyStudy

STUDIES: tuple[Study, ...] = (
    SizingStudy(),
    IdentifyStudy(),
    TuneStudy(),
    LandscapeStudy(),
    LearnStudy(),
    MonteCarloStudy(),
    SweepStudy(),
    WhyStudy(),
    FrequencySweepStudy(),
    MapStudy(),
    SharingStudy(),
    PlatformStudy(),
    ReproduceStudy(),
)
BY_KIND: dict[str, Study] = {study.kind: study for study in STUDIES}
