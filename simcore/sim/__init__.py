"""The clock, the phases of a tick and the recorder of the trajectory."""
