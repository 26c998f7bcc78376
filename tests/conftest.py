"""Every annotated shape is checked while the tests run; an ordinary run pays nothing for them."""

import os

os.environ["FIELDKIT_CHECK_SHAPES"] = "1"  # read by fieldkit.shapes when it is imported

from hypothesis import settings
from jaxtyping import install_import_hook

from tests import checker

CHECKED = ("fieldkit.simulator", "fieldkit.motors", "fieldkit.inference", "fieldkit.loop")

install_import_hook(CHECKED, f"{checker.__name__}.{checker.check.__name__}")

settings.register_profile("fieldkit", deadline=None)  # a busy machine is no fault of the code
settings.load_profile("fieldkit")
