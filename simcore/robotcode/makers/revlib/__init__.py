"""REV's SPARK MAX and SPARK Flex on mechanisms, as REVLib's simulation shows them to robot code.

REVLib keeps what robot code asks for, and what it reads, in WPILib SimDevices; what the controller makes of it is in
`SparkSim.iterate`, which adds random noise and takes a tick to be one loop. Here the controllers' own 1 kHz loops run
instead (`spark_loop`), on the clock of the physics: the same in real time and in simulated time.

- `built_sparks` notes the controllers that a program builds, and what its own simulation writes into them.
- `spark_configuration` reads what they are configured with, `spark_loop` is the control law.
- `spark_port` is one controller in the SimDevices, `spark_motor` connects it with a mechanism.
- `rev_maker` says which devices there are, who follows whom, and what an undescribed motor probably turns.

All need the extra 'rev'.
"""

import rev  # noqa: F401  # before the modules: whoever watches its import loads them
