"""The example as `robotpy deploy` copies it, on a machine without the simulation, and optionally without PathPlanner.

Arguments: the project's folder, and modules to hide.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from importlib.abc import MetaPathFinder
from pathlib import Path
from unittest.mock import Mock

from phoenix6 import unmanaged
from robotpy_installer.cli_deploy import Deploy

ABSENT = {"simcore", "games", "pybullet", "pyfrc", *sys.argv[2:]}


class NotInstalled(MetaPathFinder):
    def find_spec(self, fullname, path, target=None):
        if fullname.split(".")[0] in ABSENT:
            raise ModuleNotFoundError(f"No module named {fullname!r}", name=fullname)


def main() -> None:
    folder = Path(tempfile.mkdtemp()) / "py"
    Deploy._copy_to_tmpdir(Mock(), folder, Path(sys.argv[1]))
    os.chdir(folder)
    sys.path[:] = [str(folder), *(p for p in sys.path if not (Path(p) / "simcore").is_dir())]
    sys.meta_path.insert(0, NotInstalled())
    unmanaged.set_phoenix_diagnostics_start_time(-1)
    import hal

    hal.initialize(500, 0)
    import ntcore
    import wpilib

    wpilib.getDeployDirectory = lambda: str(folder / "deploy")
    import robot

    program = robot.Robot()
    program.robotInit()
    program.disabledPeriodic()
    program.robotPeriodic()
    wpilib.SmartDashboard.updateValues()
    options = ntcore.NetworkTableInstance.getDefault().getEntry("/SmartDashboard/Auto/options").getStringArray([])
    files = sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())
    loaded = sorted(ABSENT & {name.split(".")[0] for name in sys.modules})
    print(json.dumps({"lateness_ms": 0.0, "autos": options, "files": files, "loaded": loaded}), flush=True)
    os._exit(0)


if __name__ == "__main__":
    main()
