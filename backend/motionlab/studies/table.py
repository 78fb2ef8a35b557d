"""All studies, in the order of the command line's help."""

from __future__ import annotations

from motionlab.studies.identify.study import Identify
from motionlab.studies.loop.study import FrequencySweep
from motionlab.studies.maps.study import ComputeMap
from motionlab.studies.montecarlo.study import MonteCarlo
from motionlab.studies.paper.study import Reproduce
from motionlab.studies.platform.study import Platform
from motionlab.studies.sharing.study import Sharing
from motionlab.studies.sizing.study import Sizing
from motionlab.studies.study import Study
from motionlab.studies.sweep.study import SweepStudy
from motionlab.studies.tune.study import Landscape, Tune

STUDIES: tuple[Study, ...] = (
    Sizing(),
    Identify(),
    Tune(),
    Landscape(),
    MonteCarlo(),
    SweepStudy(),
    FrequencySweep(),
    ComputeMap(),
    Sharing(),
    Platform(),
    Reproduce(),
)
BY_KIND: dict[str, Study] = {study.kind: study for study in STUDIES}
