import hal
from wpilib import Timer
from wpilib.simulation import DriverStationSim


def test_half_a_stick_drives_two_meters_a_second(control, robot):
    DriverStationSim.setAllianceStationId(hal.AllianceStationID.kBlue1)
    DriverStationSim.setJoystickAxisCount(0, 6)
    with control.run_robot():
        control.step_timing(seconds=1.0, autonomous=False, enabled=False)
        DriverStationSim.setJoystickAxis(0, 1, -0.5)
        control.step_timing(seconds=1.0, autonomous=False, enabled=True)
        before, start = Timer.getFPGATimestamp(), robot.drivetrain.get_state().pose.X()
        control.step_timing(seconds=1.0, autonomous=False, enabled=True)
        way, time = robot.drivetrain.get_state().pose.X() - start, Timer.getFPGATimestamp() - before
        assert 2.0 < way / time < 2.4
