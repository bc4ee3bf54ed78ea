"""Where independent work is done: in this process, in local processes or on a cluster; and processes that end with
their parent.
"""

from gimbal_hil.knowledge.executor.executor import WorkExecutor, code_fingerprint, open_executor
from gimbal_hil.knowledge.executor.parentage import end_with_parent

__all__ = [
    "WorkExecutor",
    "code_fingerprint",
    "end_with_parent",
    "open_executor",
]
