from __future__ import annotations

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent))  # for scipy_flight.py, the solution that flights are compared with
