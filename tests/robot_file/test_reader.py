"""Reading of simcore.toml, and the messages about mistakes."""

import math
import re
from dataclasses import replace
from pathlib import Path

import pytest
from each_case import each

from simcore.errors import ConfigError, UnknownNameError
from simcore.robot.chassis_config import moved_points
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.hopper import HopperConfig
from simcore.robot.mechanisms import ArmSim, FlywheelConfig
from simcore.robot.robot_config import build_mechanism
from simcore.robot.storage import StorageConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot_file.reader import read_settings
from simcore.robot_file.robot_settings import RobotSettings
from simcore.world.linkage import part_pose

WHEELS = """
[[mechanism]]
name = "wheels"
kind = "flywheel"
leader = 20
followers = [21, 22]
opposed = [22]
gearing = 0.75
inertia = 0.004
"""
ROLLER = """
[[mechanism]]
name = "roller"
kind = "roller"
leader = 30
gearing = 3
"""
ARM = """
[[mechanism]]
name = "pivot"
kind = "arm"
leader = 31
gearing = 50.0
inertia = 0.2
min_deg = 0
max_deg = 90
start_deg = 90
"""
INTAKE = """
[intake]
x_min = -0.6
x_max = -0.4
y_min = -0.3
y_max = 0.3
roller = "roller"
"""


def test_the_file_selects_the_tag_layout_by_name(read):
    assert read('tags = "2025-andymark"').tags == "2025-andymark"
    with pytest.raises(ConfigError, match="2025-andymark"):
        read('tags = "andymark"')


def test_without_a_file_a_robot_gets_the_defaults(tmp_path):
    assert read_settings(tmp_path / "simcore.toml") == RobotSettings()


def test_the_bumpers_surround_the_wheels_unless_the_file_gives_the_bumper_size(read):
    around = read("").with_bumper_around(((0.3, 0.2), (-0.3, -0.2)))
    assert around.bumper == pytest.approx((0.9, 0.7))
    given = read("[robot]\nbumper_length = 0.8\nbumper_width = 0.9").with_bumper_around(((0.3, 0.2),))
    assert given.bumper == (0.8, 0.9) and given.bay is None
    open_behind = read("[robot]\nbay_depth = 0.5\nbay_width = 0.3")
    assert open_behind.robot_config(SwerveConfig.square(0.55, SwerveModuleConfig(x=0.0, y=0.0))).body.bay == (0.5, 0.3)


def test_a_robot_has_the_team_number_and_the_model_folder_in_the_file(read, tmp_path):
    with pytest.raises(
        ConfigError, match=r"\[robot\]: models must be a folder with a Robot_\.\.\. in it, but .*assets"
    ):
        read('[robot]\nmodels = "assets"')
    (tmp_path / "assets" / "Robot_Mine").mkdir(parents=True)
    settings = read('[robot]\nteam = 9999\nmodels = "assets"')
    config = settings.robot_config(SwerveConfig.square(0.55, SwerveModuleConfig(x=0.0, y=0.0)))
    assert (config.team, config.models) == (9999, (tmp_path / "assets").resolve())
    with pytest.raises(ConfigError, match="team must be a whole number from 1 to 99999"):
        read("[robot]\nteam = 0")


def test_a_complete_robot_is_read(read):
    robot = read(
        "[robot]\nmass = 48\ncapacity = 20\n[start]\nx = 3.0\ny = 2.0\nheading_deg = 90\npreload = 3\n"
        + WHEELS
        + ROLLER
        + ARM
        + INTAKE
        + 'deploy = "pivot"\nout_at = "lower"\n'
        + '[shooter]\nwheels = "wheels"\nfeeder = "roller"\nheight = 0.5\nelevation_deg = 60\nbarrels = [0.1, -0.1]\n'
        + '[[camera]]\nname = "limelight"\ntype = "LL4"\nx = 0.3\ny = 0.0\nz = 0.4\npitch_deg = -20\n'
    )
    assert (robot.mass, robot.capacity, robot.preload) == (48.0, 20, 3)
    assert robot.start == pytest.approx((3.0, 2.0, math.pi / 2))
    wheels = robot.mechanism("wheels")
    assert wheels.channels == (20, 21, 22) and wheels.opposed == wheels.followers[1:]
    assert isinstance(wheels.config, FlywheelConfig)
    assert wheels.config.gearbox.motors == 3 and wheels.config.inertia == 0.004
    pivot = build_mechanism(robot.mechanism("pivot").config)
    assert isinstance(pivot, ArmSim) and pivot.position == pytest.approx(math.pi / 2)
    (intake,), (shooter,) = robot.intakes, robot.shooters
    assert intake.deployed_at == "lower" and (intake.zone.x_min, intake.zone.z_max) == (-0.6, 0.2)
    assert shooter.wheels == ("wheels",) and shooter.gate == ("roller",)
    assert shooter.launch.barrels == (0.1, -0.1)
    assert shooter.elevation == pytest.approx(math.pi / 3)
    (camera,) = robot.cameras
    assert camera.name == "limelight" and camera.type.name == "LL4" and camera.pipelines[0].kind == "tags"
    assert (camera.mount.x, camera.mount.z, camera.mount.pitch_deg) == (0.3, 0.4, -20.0)


SHOOTER = """
[[shooter]]
height = 0.5
elevation_deg = 60
"""
TURRET = """
[[mechanism]]
name = "turret"
kind = "turret"
leader = 40
gearing = 20.0
inertia = 0.1
min_deg = -180
max_deg = 180
"""


def test_the_robot_config_has_the_values_in_the_file(read):
    robot = read(WHEELS + ROLLER + INTAKE + "[robot]\ncapacity = 7\n" + SHOOTER + 'wheels = "wheels"\n')
    built = robot.robot_config(
        SwerveConfig.square(0.5, SwerveModuleConfig(x=0.0, y=0.0)), storage=StorageConfig(capacity=3, order="lifo")
    )
    assert list(built.mechanisms) == ["wheels", "roller"]
    assert built.bumper == pytest.approx((0.8, 0.8))
    assert (built.storage.capacity, built.storage.order) == (7, "lifo")
    assert built.intakes == robot.intakes and built.shooters == robot.shooters
    assert (
        read("")
        .robot_config(SwerveConfig.square(0.5, SwerveModuleConfig(x=0.0, y=0.0)), storage=StorageConfig(capacity=3))
        .storage.capacity
        == 3
    )


@each(
    ("text", "said"),
    [
        ("[robot]\nmas = 50", "simcore.toml [robot]: no key 'mas'. Did you mean 'mass'? Known: battery_resistance"),
        ("[start]\nyaw_deg = 90", "simcore.toml [start]: no key 'yaw_deg'. Did you mean 'heading_deg'? Known:"),
        ("[scatter]\nexit_sped = 1", "[scatter]: no key 'exit_sped'. Did you mean 'exit_speed'?"),
        ("[autos.left]\nstart = [1, 2, 3]\nspeed = 1", "[autos.'left']: no key 'speed'"),
        ("[robbot]\nmass = 50", "simcore.toml: no key 'robbot'. Did you mean 'robot'?"),
        ("[robot]\nmass = -50", "simcore.toml [robot]: mass must be a number from 20 to 75 kg, got -50"),
        ("[robot]\nmass = '50'", "simcore.toml [robot]: mass must be a number from 20 to 75 kg, got '50'"),
        ("[robot]\nmass = true", "mass must be a number from 20 to 75 kg, got True"),
        ("[robot]\nmass = nan", "mass must be a number from 20 to 75 kg, got nan"),
        ("[robot]\nbumper_length = 0.8", "[robot]: bumper_length needs bumper_width = <m> as well"),
        ("[robot]\nbay_width = 0.3", "[robot]: bay_width needs bay_depth = <m> as well"),
        ("[robot]\nmass = 125", "[robot]: mass must be a number from 20 to 75 kg, got 125. As pounds that is 56.7 kg"),
        ("[robot]\nmass = 5", "[robot]: mass must be a number from 20 to 75 kg, got 5"),
        (
            "[robot]\nbumper_length = 34\nbumper_width = 30",
            "[robot]: bumper_length must be a number from 0.4 to 1.2 m, got 34. As inches that is 0.864 m",
        ),
        ("[robot]\nbumper_length = 86\nbumper_width = 80", "got 86. As cm that is 0.86 m"),
        (
            "[robot]\ncenter_of_mass_height = 8",
            "must be a number above 0 and up to 1 m, got 8. As inches that is 0.203 m",
        ),
        (ROLLER + INTAKE.replace("-0.6", "-24"), "x_min must be a number from -3 to 3 m, got -24. As inches"),
        (
            "[autos.left]\nstart = [1, 2]",
            "start must be 3 numbers (m, m, deg), got [1, 2]",
        ),
        ("[autos]\nleft = [1, 2, 3]", "[autos]: left must be a table, written [autos.'left'] on its own line"),
        ("[[storage]]\ncapacity = 3\n[[storage]]\ncapacity = 3", "[[storage]]: give each of several storages a name"),
        ("[storage]\ncapacity = 3\nx_min = 0.5", "[storage]: x_min must be below x_max, got 0.5 and 0.15 m"),
        (ROLLER + INTAKE + 'storage = "front"', "storage must name a storage, but there is no [[storage]] in the file"),
        (
            ARM + 'on = "lift"',
            "'pivot': on must name an arm, a turret, an elevator or a rack, got 'lift'; those of the",
        ),
        (ARM + 'on = "pivot"', "'pivot': on forms a loop: pivot on pivot"),
        (ROLLER + 'on = "pivot"', "[[mechanism]] 'roller': no key 'on'"),
        (
            ROLLER + '[[claw]]\nroller = "roller"',
            "[[claw]] 1: on must name a mechanism, but there is no [[mechanism]] of kind",
        ),
        (ROLLER + '[[component]]\nname = "a"', "[[component]] 'a': on is missing; it must be the mechanism that moves"),
        (
            ROLLER + ARM + '[[claw]]\non = "pivot"\nroller = "roller"\nhandover = [0.1, 0.0, 0.5]',
            "[[claw]] 1: handover needs from_storage = true as well",
        ),
        (ROLLER + '[[climber]]\non = "roller"', "on must name a mechanism, but there is no [[mechanism]] of kind arm,"),
        ("[robot]\ndrive_motor = 'Kraken X6O'", "drive_motor must be one of"),
        ("[robot]\ndrive_motor = 'Kraken X6O'", "got 'Kraken X6O'. Did you mean 'Kraken X60'?"),
        (
            "[robot]\ncapacity = 50\n[start]\npreload = 60",
            "[start]: preload must be at most the robot's capacity, 50; got 60",
        ),
        ("robot = 3", "simcore.toml: robot must be a table, written [robot] on its own line; got 3"),
        ("[robot\nmass = 1", "simcore.toml: is not valid TOML: "),
        ("[mechanism]\nname = 'a'", "mechanism must be tables, each under a line [[mechanism]]"),
        (WHEELS + "intertia = 1", "[[mechanism]] 'wheels': no key 'intertia'. Did you mean 'inertia'?"),
        (
            WHEELS.replace("flywheel", "flywhel"),
            "kind must be one of flywheel, roller, arm, turret, elevator, rack, servo, piston, got",
        ),
        (WHEELS.replace("[22]", "[23]"), "opposed must name followers, which are [21, 22]; got 23"),
        (
            WHEELS.replace("leader = 20", "leader = 63"),
            'leader must be a whole number from 0 to 62, or as "canivore:3" on another bus, got 63',
        ),
        (
            WHEELS.replace("leader = 20", "leader = 20.0"),
            'leader must be a whole number from 0 to 62, or as "canivore:3" on another bus, got 20.0',
        ),
        (WHEELS + WHEELS, "[[mechanism]] 'wheels': name is used twice"),
        (WHEELS + ROLLER.replace("30", "21"), "'roller': TalonFX 21 already belongs to 'wheels'"),
        (WHEELS.replace("[21, 22]", "[20, 22]"), "'wheels': TalonFX 20 already belongs to 'wheels'"),
        (ROLLER + "cancoder_gearing = 2", "cancoder_gearing needs cancoder = <CAN id> as well"),
        (ARM.replace("max_deg = 90", "max_deg = -5"), "[[mechanism]] 'pivot': min_deg must be below max_deg, got"),
        (INTAKE, "[intake]: roller must name a mechanism, but there is no [[mechanism]] in the file"),
        (ROLLER + INTAKE.replace('"roller"', '"rollr"'), "roller must be one of roller, got 'rollr'. Did you mean"),
        (ROLLER + INTAKE.replace("-0.6", "0.6"), "[intake]: x_min must be below x_max, got 0.6 and -0.4 m"),
        (ROLLER + INTAKE + 'deploy = "roller"', "deploy must be an arm, elevator or rack, which has stops"),
        (ROLLER + INTAKE + 'out_at = "upper"', "out_at needs deploy = <mechanism> as well"),
        (
            ROLLER + '[shooter]\nwheels = "roller"\nheight = 0.5\nelevation_deg = 60',
            "[shooter]: wheels must be a mechanism of kind flywheel, got 'roller'",
        ),
        (
            WHEELS + SHOOTER + 'wheels = ["wheels", "whels"]',
            "[[shooter]] 1: wheels[1] must be one of wheels, got 'whels'. Did you mean 'wheels'?",
        ),
        (WHEELS + SHOOTER + 'wheels = ["wheels", "wheels"]', "must be one flywheel, or two: [lower, upper]; got ["),
        (WHEELS + SHOOTER + "wheels = 3", "wheels must be a text in quotes, got 3"),
        (WHEELS + SHOOTER, "[[shooter]] 1: wheels is missing; it must be one of wheels, or a list of such"),
        (WHEELS + SHOOTER + 'wheels = "wheels"\nfeeder = []', "feeder must be one of wheels, or a list of such; got"),
        (WHEELS + SHOOTER + 'wheels = "wheels"\nturret = "turet"', "turret must be one of wheels, got 'turet'"),
        (
            WHEELS + SHOOTER + 'wheels = "wheels"\nturret_ratio = 2',
            "turret_ratio needs turret = <mechanism> as well",
        ),
        (ROLLER + INTAKE + "kinds = 1", "[intake]: kinds must be a text in quotes, got 1"),
        ("intake = 1", "simcore.toml: intake must be tables, each under a line [[intake]]; got 1"),
        ("[robot]\ngame = 'x'", "[robot]: no key 'game'"),
        (
            WHEELS + '[shooter]\nwheels = "wheels"\nheight = 0.5\nelevation_deg = 60\nbarrels = []',
            "barrels must be a number from -3 to 3 m, or a list of such; got []",
        ),
        ("[[camera]]\nname = 'a'\ntype = 'LL4'\nx=0\ny=0\nz=0\nmode = 'tag'", "mode must be one of tags, pieces, got"),
        ("[[camera]]\nname = 'a'\ntype = 'LL5'\nx=0\ny=0\nz=0", "type must be one of LL3, LL3A, LL3G, LL4, got 'LL5'"),
        ("[[camera]]\nname = 'a/b'\ntype = 'LL4'\nx=0\ny=0\nz=0", "name must be a NetworkTables name without '/'"),
        ("[[camera]]\nname = 'a'\nx=0\ny=0\nz=0", "[[camera]] 'a': type is missing; it must be one of LL3, LL3A, LL3G"),
    ],
)
def test_the_error_for_each_mistake_in_the_file_names_the_table_and_the_key(read, text, said):
    with pytest.raises(ConfigError) as error:
        read(text)
    assert said in str(error.value)


@each(
    ("kind", "guessed"),
    [
        ("flywheel", {"gearing": 1.0, "inertia": 0.00056}),
        ("roller", {"gearing": 1.0}),
        ("arm", {"gearing": 1.0, "inertia": 0.00056, "min_deg": -180.0, "max_deg": 180.0}),
        ("turret", {"gearing": 1.0, "inertia": 0.00056, "min_deg": -180.0, "max_deg": 180.0}),
        ("elevator", {"gearing": 1.0, "mass": 5.0, "drum_radius": 0.02, "max_height": 1.0}),
        ("rack", {"gearing": 1.0, "mass": 3.0, "pinion_radius": 0.02, "travel": 0.3}),
    ],
)
def test_a_mechanism_with_only_kind_and_motor_lists_every_assumed_value(read, kind, guessed):
    one = read(f'[[mechanism]]\nname = "one"\nkind = "{kind}"\nleader = 3\n').mechanism("one")
    assert one.guessed == pytest.approx(guessed, rel=0.05)
    assert one.guesses.startswith("gearing = 1") and one.guesses.count("=") == len(guessed)
    assert build_mechanism(one.config).position == pytest.approx(0.0)
    told = one.with_program(5.0, 0.02)
    assert told.config.gearbox.gearing == told.guessed["gearing"] == 5.0
    assert getattr(told.config, "inertia", None) == {"roller": 0.001}.get(kind, guessed.get("inertia") and 0.02)
    assert _friction_volts(told) == pytest.approx(_friction_volts(one))
    said = read(f'[[mechanism]]\nname = "one"\nkind = "{kind}"\nleader = 3\ngearing = 2.0\n').mechanism("one")
    assert "gearing" not in said.guessed and said.with_program(5.0, 0.02).config.gearbox.gearing == 2.0


def test_servos_and_pistons_list_every_assumed_value(read):
    servo = read('[[mechanism]]\nname = "one"\nkind = "servo"\npwm = 1\n').mechanism("one")
    assert servo.guesses == "min_deg = 0, max_deg = 180, deg_per_second = 400" and servo.with_program(5.0, 1.0) == servo
    assert read('[[mechanism]]\nname = "a"\nkind = "piston"\nsolenoid = 1\n').mechanism("a").guessed == {
        "stroke": 0.2, "stroke_time": 0.4
    }  # fmt: skip


LIFT = """
[[mechanism]]
name = "lift"
kind = "elevator"
leader = 60
gearing = 9
mass = 6
drum_radius = 0.02
max_height = 1.2
x = 0.1
z = 0.3
lean_deg = 30
"""


def test_an_arm_on_an_elevator_carries_a_claw(read):
    """The elevator leans 30 degrees forward and is half a meter up; the arm hangs straight down at the back."""
    robot = read(
        ROLLER
        + LIFT
        + ARM.replace("min_deg = 0", "min_deg = -90").replace("start_deg = 90", "start_deg = -90")
        + 'on = "lift"\nyaw_deg = 180\nz = 0.05\n'
        + '[[claw]]\non = "pivot"\nx = -0.4\nroller = "roller"\nsize = [0.2, 0.2, 0.1]\n'
        + '[[component]]\nname = "carriage"\non = "lift"\n[[component]]\nname = "arm"\non = "pivot"\nz = 0.1\n'
        + '[[component]]\nname = "stage"\non = "lift"\nshare = 0.5\n'
        + '[[component]]\nname = "wheel"\non = "pivot"\nroller = "roller"\nx = -0.3\n'
    )
    (claw,) = robot.placers
    config = robot.robot_config(SwerveConfig.square(0.5, SwerveModuleConfig(x=0, y=0)))
    carriage, arm, stage, wheel = config.components
    assert stage.joints == (replace(carriage.joints[0], ratio=0.5 * carriage.joints[0].ratio),)
    assert wheel.joints[:-1] == arm.joints
    assert (wheel.joints[-1].mechanism, wheel.joints[-1].origin) == ("roller", (-0.3, 0.0, 0.0))
    assert (carriage.joints, arm.joints, arm.offset) == (claw.joints[:1], claw.joints, (0.0, 0.0, 0.1))
    mechanisms = {name: build_mechanism(robot.mechanism(name).config) for name in ("lift", "pivot", "roller")}
    mechanisms["lift"].position = 0.5 / 0.02
    (x, y, z), _ = part_pose(claw.joints, mechanisms, claw.offset)
    assert (x, y) == pytest.approx((0.1 + 0.5 * math.sin(math.pi / 6), 0.0))
    assert z == pytest.approx(0.3 + 0.5 * math.cos(math.pi / 6) + 0.05 - 0.4)
    mechanisms["pivot"].position = 0.0
    (level, _, height), _ = part_pose(claw.joints, mechanisms, claw.offset)
    assert (level - x, height - z) == pytest.approx((-0.4, 0.4)), "to the back when it is level"
    assert (claw.zone.x_min, claw.zone.x_max, claw.zone.z_max) == pytest.approx((-0.5, -0.3, 0.05))
    lift = robot.mechanism("lift").config
    assert lift.gravity == pytest.approx(9.80665 * math.cos(math.pi / 6), rel=1e-4)


def test_shooters_have_their_own_storages_and_feeder_directions(read):
    robot = read(
        "[robot]\ncapacity = 4\n[[storage]]\nname = 'front'\ncapacity = 9\norder = 'lifo'\n[[storage]]\nname = 'back'\n"
        + WHEELS
        + WHEELS.replace('"wheels"', '"upper"').replace("20", "50").replace("21, 22", "51, 52").replace("[22]", "[52]")
        + ROLLER
        + TURRET
        + "x = -0.1\ny = 0.05\n"
        + INTAKE.replace("[intake]", "[[intake]]")
        + INTAKE.replace("[intake]", "[[intake]]")
        + 'storage = "back"\ntakes_in = "backward"\n'
        + 'kinds = ["Cube", "Cone"]\n'
        + SHOOTER
        + 'wheels = ["wheels", "upper"]\nwheel_radius = [0.05, 0.03]\nside_by_side = true\nfeeder = "roller"\n'
        + SHOOTER
        + 'wheels = "wheels"\nfeeder = "roller"\nfeeder_backward = "roller"\nstorage = "back"\nturret = "turret"\n'
        + 'turret_ratio = 0.5\nkinds = "Cube"\n'
    )
    assert [(s.name, s.capacity, s.order) for s in robot.storages] == [("front", 9, "lifo"), ("back", 4, "fifo")]
    assert [(i.storage, i.roller_reversed) for i in robot.intakes] == [("", False), ("back", True)]
    assert [i.kinds for i in robot.intakes] == [(), ("Cube", "Cone")]
    first, second = robot.shooters
    assert first.exit_efficiency == 2.0 * second.exit_efficiency and second.kinds == ("Cube",)
    assert first.wheel_radii == (0.05, 0.03) and first.wheel_places == "left and right"
    assert (first.gate_reversed, second.gate_reversed, second.storage) == ((), ("roller",), "back")
    assert (second.launch.pivot_x, second.launch.pivot_y) == (-0.1, 0.05), "where the turret is"
    assert second.turret_ratio == 0.5 and build_mechanism(robot.mechanism("turret").config).holding_volts == 0.0
    with pytest.raises(UnknownNameError, match=r"no kind of piece named 'Cube'\. Did you mean 'Cone'"):
        robot.require_pieces(["Cone"])
    config = robot.robot_config(SwerveConfig.square(0.5, SwerveModuleConfig(x=0, y=0)))
    assert config.storage.name == "front" and [s.name for s in config.more_storages] == ["back"]


def test_an_outlet_turns_a_storage_into_a_hopper(read):
    text = "[[storage]]\ncapacity = 9\noutlet = 'front'\noutlet_width = 0.36\nbelt = 'roller'\nfunnel_deg = 30\n"
    robot = read(ROLLER + text + "outlet_place = [0.0, 0.35]\n")
    hopper = HopperConfig(outlet_width=0.36, belt="roller", funnel=math.radians(30.0), outlet_place=(0.0, 0.35))
    assert robot.storages[0].hopper == hopper
    assert read("[storage]\ncapacity = 9\n").storages[0].hopper is None
    for wrong, words in (
        ("[storage]\ncapacity = 9\noutlet = 'front'\n", "outlet needs outlet_width = <m> as well"),
        ("[storage]\ncapacity = 9\noutlet_width = 0.3\n", "outlet_width needs outlet = <side> as well"),
        (ROLLER + text.replace("'roller'", "'rolls'"), "belt must be"),
        (ROLLER + text.replace("30", "90"), r"\[\[storage\]\] 1: funnel_deg must be a number from 0 to 68 deg, got 90"),
    ):
        with pytest.raises(ConfigError, match=words):
            read(wrong)


def test_the_arm_on_an_elevator_in_the_docs_is_read(read):
    page = Path(__file__).resolve().parents[2] / "docs" / "robot.md"
    blocks = re.findall(r"^```toml\n(.*?)^```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    (text,) = [block for block in blocks if "[[claw]]" in block]
    (claw,) = read(text).placers
    assert [(joint.mechanism, joint.slides) for joint in claw.joints] == [("elevator", True), ("arm", False)]


def test_the_start_of_each_auto_is_read(read):
    robot = read('[autos."Left two piece"]\nstart = [3.0, 5.5, -90]\n[autos.right]\nstart = [3, 2.5, 0]\n')
    assert robot.auto_starts == {"Left two piece": (3.0, 5.5, pytest.approx(-math.pi / 2)), "right": (3.0, 2.5, 0.0)}


def test_controllers_of_two_models_may_have_the_same_id(read):
    robot = read(ROLLER + ROLLER.replace('"roller"\nkind', '"other"\nkind') + 'controller = "TalonFXS"')
    assert [m.controller for m in robot.mechanisms] == ["TalonFX", "TalonFXS"]


def test_a_file_that_is_not_text_is_refused(tmp_path):
    path = tmp_path / "simcore.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ConfigError, match="is not UTF-8 text"):
        read_settings(path)


def test_friction_comes_from_the_file_a_ks_or_a_default_of_kind_and_motor(tmp_path):
    path = tmp_path / "simcore.toml"
    path.write_text(WHEELS + ROLLER + ARM.replace("gearing = 50.0", "gearing = 50.0\nfriction_volts = 0.4"))
    robot = read_settings(path)
    wheels, roller, pivot = (robot.mechanism(name) for name in ("wheels", "roller", "pivot"))
    volts = {m.name: _friction_volts(m) for m in (wheels, roller, pivot)}
    motor = wheels.config.gearbox.motor
    assert volts["wheels"] == pytest.approx(motor.free_current * motor.resistance)  # the datasheet's no-load current
    assert volts["roller"] == pytest.approx(0.2)
    assert volts["pivot"] == pytest.approx(0.4)
    told = robot.with_friction({"roller": 0.31, "pivot": 0.1})
    assert _friction_volts(told.mechanism("roller")) == pytest.approx(0.31)
    assert _friction_volts(told.mechanism("pivot")) == pytest.approx(0.4)  # the file states it
    path.write_text(ROLLER + "friction_torque = 0.1\nfriction_volts = 0.1")
    with pytest.raises(ConfigError, match="friction_volts means the same as friction_torque"):
        read_settings(path)


def _friction_volts(mechanism):
    gearbox = mechanism.config.gearbox
    return gearbox.friction_torque * gearbox.resistance / gearbox.torque_per_amp


def test_sparks_have_their_usual_motor_and_their_own_encoder(tmp_path):
    path = tmp_path / "simcore.toml"
    path.write_text(ROLLER + 'controller = "SPARK Flex"\nencoder_gearing = 2.5')
    roller = read_settings(path).mechanism("roller")
    assert (roller.controller, roller.motor, roller.encoder_gearing) == ("SPARK Flex", "NEO Vortex", 2.5)
    for keys, problem in (
        ('controller = "SPARK MAX"\ncancoder = 3', "cancoder is for a TalonFX; a SPARK MAX has encoder_gearing"),
        ("encoder_gearing = 2", "encoder_gearing is for a SPARK MAX or SPARK Flex; the controller is a TalonFX"),
        ('controller = "SPARK"', "Did you mean 'SPARK MAX'"),
        (
            'controller = "Talon SRX"',
            r"controller cannot be 'Talon SRX': Phoenix 5 .* is not simulated: .* TalonFX, SPARK",
        ),
    ):
        path.write_text(ROLLER + keys)
        with pytest.raises(ConfigError, match=problem):
            read_settings(path)


MASSES = """
[robot]
mass = 50.0

[[mechanism]]
name = "lift"
kind = "elevator"
leader = 20
gearing = 10.0
mass = 8.0
drum_radius = 0.02
max_height = 1.5
x = 0.1
z = 0.4
{lift}

[[mechanism]]
name = "arm"
kind = "arm"
leader = 21
gearing = 50.0
inertia = 0.4
mass = 3.0
center_of_mass = 0.3
min_deg = -90.0
max_deg = 90.0
start_deg = 0.0
on = "lift"
yaw_deg = 90.0

[[mechanism]]
name = "turret"
kind = "turret"
leader = 22
gearing = 50.0
inertia = 0.4
min_deg = -90.0
max_deg = 90.0
{turret}
"""


def test_mechanisms_move_the_masses_in_the_file(tmp_path):
    """An elevator lifts its carriage and the arm on it; a turret moves only a mass that the file gives."""
    path = tmp_path / "simcore.toml"
    path.write_text(MASSES.format(lift="", turret=""))
    settings = read_settings(path)
    assert [(one.name, one.mass) for one in settings.moving_masses] == [("lift", 5.0), ("arm", 3.0)]
    assert [len(one.joints) for one in settings.moving_masses] == [1, 2]
    config = settings.robot_config(SwerveConfig.square(0.5, SwerveModuleConfig(x=0.0, y=0.0), mass=50.0))
    assert config.bare_body.mass == pytest.approx(42.0)
    start = {name: build_mechanism(one) for name, one in config.mechanisms.items()}
    assert moved_points(config.moving_masses, start)[1][1] == pytest.approx((0.1, 0.3, 0.4))
    path.write_text(MASSES.format(lift="moving_mass = 9.0", turret="moving_mass = 2.0\nmass_center = [0.1, 0.0, 0.3]"))
    masses = read_settings(path).moving_masses
    assert [(one.name, one.mass) for one in masses] == [("lift", 9.0), ("arm", 3.0), ("turret", 2.0)]
    assert masses[2].center == (0.1, 0.0, 0.3)


def test_a_file_with_a_byte_order_mark_is_read(tmp_path):
    """Notepad and PowerShell 5 write UTF-8 in this way."""
    path = tmp_path / "simcore.toml"
    path.write_bytes(b"\xef\xbb\xbf[robot]\nmass = 48\n")
    assert read_settings(path).mass == 48.0


def test_friction_values_in_the_file_apply_to_any_drivetrain(read):
    """The values apply even to a drivetrain from CTRE's constants, whose friction values are placeholders."""
    robot = read(
        "[robot]\ntread = 1.8\nwheel_grain = 0.73\ndrive_friction_volts = 0.4\nsteer_friction_volts = 0.3\n"
        "bumper_friction = 0.5\n"
    )
    assert robot.wheel_cof == 1.8
    built = robot.robot_config(SwerveConfig.square(0.5, SwerveModuleConfig(x=0.0, y=0.0)))
    for module in built.drivetrain.modules:
        assert (module.wheel_grain, module.drive_friction_volts, module.steer_friction_volts) == (0.73, 0.4, 0.3)
    assert built.body.bumper_friction == 0.5
    tank = robot.robot_config(TankConfig()).drivetrain
    assert (tank.wheel_grain, tank.friction_volts) == (0.73, 0.4)
    untold = SwerveConfig.square(0.5, SwerveModuleConfig(x=0.0, y=0.0))
    assert read("").robot_config(untold).drivetrain == untold
