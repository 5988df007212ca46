"""The summary at the start of a run fits on one screen, whatever the robot has."""

from simcore.robotcode.sim.startup_summary import StartupSummary


def test_many_devices_of_every_kind_fit_on_one_screen():
    lines = StartupSummary(
        robot="Robot is on the field of REBUILT (2026): 55 kg, bumpers 0.80 x 0.80 m",
        drivetrain="TalonFX 1-4 11-14, CANcoder 21-24, Pigeon2 9",
        described=[f"'mechanism {k}': TalonFX {k}" for k in range(20)],
        guessed=[(f"SPARK MAX {k} + {k + 1}", "1 x NEO, 3:1, 0.001 kg m^2") for k in range(30, 60)],
        own="SPARK MAX 61",
        sensors=[f"'beam {k}' sees pieces: DIO {k}" for k in range(20)],
        lights="CANdle 40",
        nobody="CANrange 3, " + ", ".join(f"navX-Sensor[{k}]" for k in range(40)),
        cameras="limelight",
        unseen="front",
        is_on_network=True,
    ).lines()
    assert len(lines) <= 30 and max(map(len, lines)) <= 120
    text = "\n".join(lines)
    for expected in (
        "sensors      'beam 0' sees pieces: DIO 0", "lights       CANdle 40: shown as Sim/Lights in telemetry",
        "'mechanism 0': TalonFX 0", "and 15 more", "SPARK MAX 30 + 31: 1 x NEO", "and 25 more",
        "own physics  SPARK MAX 61",
        "not moved    CANrange 3",
        "cameras      limelight; your program asks for front",
        "network      WPILib (5810, 1735)",
        "leader = 30 and gearing in simcore.toml",
    ):  # fmt: skip
        assert expected in text, expected


def test_a_missing_intake_is_reported():
    lines = StartupSummary(robot="Robot", drivetrain="TalonFX 1-8", pushed="fuel").lines()
    assert any("intake       not described: fuel is pushed, not taken in" in line for line in lines)
    assert not any("intake" in line for line in StartupSummary(robot="Robot", drivetrain="TalonFX 1-8").lines())


def test_without_a_robot_file_the_screen_names_simcore_init():
    lines = StartupSummary(robot="Robot", drivetrain="TalonFX 1-8", has_file=False).lines()
    assert "`simcore init` writes a simcore.toml" in lines[-1]
    assert not any("network" in line for line in lines), "a test listens nowhere"


def test_a_second_simulation_is_reported():
    lines = StartupSummary(robot="Robot", drivetrain="TalonFX 1-8", is_on_network=False).lines()
    assert "holds port 5810 of NetworkTables: dashboards show that one" in " ".join(" ".join(lines).split())
