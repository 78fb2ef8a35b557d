"""All studies, in the order of the command line's help."""

from __future__ import annotations

from motionlab.paper.study import ReproduceStudy
from motionlab.studies.friction.study import FrictionModelsStudy
from motionlab.studies.identify.study import IdentifyStudy
from motionlab.studies.learn.study import LearnStudy
from motionlab.studies.loop.study import FrequencySweepStudy
from motionlab.studies.maps import MapStudy
from motionlab.studies.minute.study import MinuteStudy
from motionlab.studies.montecarlo.study import MonteCarloStudy
from motionlab.studies.own import own_studies
from motionlab.studies.platform import PlatformStudy
from motionlab.studies.response.study import ResponseStudy
from motionlab.studies.safe_tune.study import SafeTuneStudy
from motionlab.studies.sensitivity.study import SensitivityStudy
from motionlab.studies.shape.study import ShapeStudy
from motionlab.studies.sharing.study import SharingStudy
from motionlab.studies.sizing import SizingStudy
from motionlab.studies.study import Study
from motionlab.studies.sweep.study import SweepStudy
from motionlab.studies.tune.study import LandscapeStudy, TuneStudy
from motionlab.studies.why.study import WhyStudy

SHIPPED: tuple[Study, ...] = (
    SizingStudy(),
    IdentifyStudy(),
    FrictionModelsStudy(),
    TuneStudy(),
    LandscapeStudy(),
    SafeTuneStudy(),
    LearnStudy(),
    MonteCarloStudy(),
    SweepStudy(),
    SensitivityStudy(),
    WhyStudy(),
    MinuteStudy(),
    ResponseStudy(),
    ShapeStudy(),
    FrequencySweepStudy(),
    MapStudy(),
    SharingStudy(),
    PlatformStudy(),
    ReproduceStudy(),
)
OWN = own_studies(SHIPPED, ("simulate", "replay", "replays"))
"""Studies of one's own."""
STUDIES: tuple[Study, ...] = (*SHIPPED, *OWN)
BY_KIND: dict[str, Study] = {study.kind: study for study in STUDIES}
