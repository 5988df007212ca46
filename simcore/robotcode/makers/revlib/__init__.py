"""REV's SPARK MAX and SPARK Flex on mechanisms, as robot code reads them through REVLib's simulation.

REVLib keeps robot code's requests and readings in WPILib SimDevices; its model of the controller is
`SparkSim.iterate`, which adds random noise and treats a tick as one loop. Here the controllers' own 1 kHz loops run
instead (`spark_loop`), on the clock of the physics, equally in real time and in simulated time.

- `built_sparks` records the controllers that a program builds, and writes of its own simulation to them.
- `spark_configuration` reads their configuration, `spark_loop` is the control law.
- `spark_port` is one controller in the SimDevices, `spark_motor` connects it to a mechanism.
- `rev_maker` lists the devices, their leaders, and the likely mechanism of an undescribed motor.

All need the extra 'rev'.
"""

import rev  # noqa: F401  # before the modules: an import hook loads them
