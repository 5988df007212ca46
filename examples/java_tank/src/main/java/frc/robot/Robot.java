package frc.robot;

import edu.wpi.first.math.controller.PIDController;
import edu.wpi.first.wpilibj.Encoder;
import edu.wpi.first.wpilibj.TimedRobot;
import edu.wpi.first.wpilibj.motorcontrol.PWMSparkMax;

/** A tank drive: PWM 0 and 1, encoders, a speed loop; 1 m/s in auto. */
public class Robot extends TimedRobot {
  private final PWMSparkMax left = new PWMSparkMax(0);
  private final PWMSparkMax right = new PWMSparkMax(1);
  private final Encoder leftEncoder = new Encoder(0, 1);
  private final Encoder rightEncoder = new Encoder(2, 3);
  private final PIDController leftLoop = new PIDController(0.5, 0.0, 0.0);
  private final PIDController rightLoop = new PIDController(0.5, 0.0, 0.0);

  public Robot() {
    leftEncoder.setDistancePerPulse(0.000234);
    rightEncoder.setDistancePerPulse(0.000234);
  }

  @Override
  public void autonomousPeriodic() {
    left.set(0.25 + leftLoop.calculate(leftEncoder.getRate(), 1.0));
    right.set(0.25 + rightLoop.calculate(rightEncoder.getRate(), 0.95));
  }

  @Override
  public void disabledPeriodic() {
    left.set(0.0);
    right.set(0.0);
  }
}
