"""The tests; what the package says about threads of linear algebra is said before anything loads numpy."""

import gimbal_hil  # noqa: F401
