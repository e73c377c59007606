"""Every error a user can meet."""

from robolaser.errors.base import *  # noqa: F403
from robolaser.errors.files import *  # noqa: F403
from robolaser.errors.types import (
    AlgorithmError as AlgorithmError,
)
from robolaser.errors.types import (
    ArmError as ArmError,
)
from robolaser.errors.types import (
    BenchmarkError as BenchmarkError,
)
from robolaser.errors.types import (
    CameraError as CameraError,
)
from robolaser.errors.types import (
    DataError as DataError,
)
from robolaser.errors.types import (
    DependencyMissing as DependencyMissing,
)
from robolaser.errors.types import (
    EffectError as EffectError,
)
from robolaser.errors.types import (
    EstimationError as EstimationError,
)
from robolaser.errors.types import (
    ImageError as ImageError,
)
from robolaser.errors.types import (
    Interrupted as Interrupted,
)
from robolaser.errors.types import (
    LineLost as LineLost,
)
from robolaser.errors.types import (
    OutputError as OutputError,
)
from robolaser.errors.types import (
    PlanError as PlanError,
)
from robolaser.errors.types import (
    PluginError as PluginError,
)
from robolaser.errors.types import (
    RobotError as RobotError,
)
from robolaser.errors.types import (
    ScanError as ScanError,
)
from robolaser.errors.types import (
    TrialError as TrialError,
)
from robolaser.errors.types import (
    UsageError as UsageError,
)
