"""Adapters to REV's SPARK MAX and SPARK Flex, with control loops at 1 kHz.

REVLib keeps robot code's requests and readings in WPILib SimDevices. REVLib's controller model, `SparkSim.iterate`,
adds random noise and runs one loop per call. The 1 kHz loops in `spark_loop` replace this model. The loops run on the
physics clock, in real time and in simulated time.

- `built_sparks` records the controllers that a program builds, and checks writes of the program's own simulation.
- `spark_configuration` reads a controller's configuration; `spark_loop` is the control law.
- `spark_port` connects one controller to its SimDevices; `spark_motor` connects controllers to a mechanism.
- `rev_maker` lists devices and their leaders, and guesses the mechanism of an undescribed motor.

All modules need the extra 'rev'.
"""

import rev  # noqa: F401  # first, because an import hook loads the modules of this package
