"""For page_reader.py, which tests of several folders share."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent / "pages"))  # in a folder without games/
