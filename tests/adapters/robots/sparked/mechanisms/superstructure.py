"""REV motor controllers of every kind, and a feeder on a TalonFX that coasts."""

import measures
import rev
from phoenix6 import configs, controls, signals
from wpimath.system.plant import DCMotor

SAVE = rev.ResetMode.kResetSafeParameters, rev.PersistMode.kPersistParameters
BRUSHLESS = rev.SparkLowLevel.MotorType.kBrushless
CONTROL = rev.SparkLowLevel.ControlType


class Superstructure:
    def __init__(self, ids: dict) -> None:
        front, back = ids["intake"]
        self.intake, self.intake_follower = rev.SparkMax(front, BRUSHLESS), rev.SparkMax(back, BRUSHLESS)
        self.intake.configure(rev.SparkMaxConfig().inverted(True).smartCurrentLimit(40), *SAVE)
        self.intake_follower.configure(rev.SparkMaxConfig().follow(front, True), *SAVE)
        self.shooter = rev.SparkFlex(ids["shooter"], BRUSHLESS)
        config = rev.SparkFlexConfig()
        config.closedLoop.pid(0.0002, 0, 0).feedForward.kS(0.15).kV(12 / 6784)
        self.shooter.configure(config, *SAVE)
        self.hood = rev.SparkMax(ids["hood"], BRUSHLESS)
        config = rev.SparkMaxConfig()
        config.encoder.positionConversionFactor(360 / 40).velocityConversionFactor(6 / 40)
        config.absoluteEncoder.positionConversionFactor(360).velocityConversionFactor(6)
        config.closedLoop.setFeedbackSensor(rev.FeedbackSensor.kAbsoluteEncoder).pid(0.02, 0, 0)
        self.hood.configure(config, *SAVE)
        self.winch = rev.SparkMax(ids["winch"], BRUSHLESS)
        self.winch_sim = rev.SparkMaxSim(self.winch, DCMotor.NEO(1))  # simulated by the team
        self.feeder = measures.talon(ids["feeder"], ratio=2.0)
        self.feeder.configurator.apply(configs.MotorOutputConfigs().with_neutral_mode(signals.NeutralModeValue.COAST))

    def simulate(self) -> None:
        self.winch_sim.iterate(100.0 * self.winch.getAppliedOutput(), 12.0, 0.02)

    def run(self, is_pressed: bool) -> None:
        self.intake.set(0.6 if is_pressed else 0.0)
        self.hood.getClosedLoopController().setSetpoint(30.0, CONTROL.kPosition)
        self.winch.set(0.5)
        if is_pressed:
            self.shooter.getClosedLoopController().setSetpoint(3500.0, CONTROL.kVelocity)
            self.feeder.set_control(controls.VoltageOut(6.0))
        else:
            self.shooter.set(0.0)
            self.feeder.set_control(controls.NeutralOut())
