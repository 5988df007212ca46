// A tank drive: PWM 0 and 1, encoders, a speed loop; 1 m/s in auto.
#include <frc/Encoder.h>
#include <frc/TimedRobot.h>
#include <frc/controller/PIDController.h>
#include <frc/motorcontrol/PWMSparkMax.h>

class Robot : public frc::TimedRobot {
  frc::PWMSparkMax left{0}, right{1};
  frc::Encoder leftEncoder{0, 1}, rightEncoder{2, 3};
  frc::PIDController leftLoop{0.5, 0.0, 0.0}, rightLoop{0.5, 0.0, 0.0};

 public:
  Robot() {
    leftEncoder.SetDistancePerPulse(0.000234);
    rightEncoder.SetDistancePerPulse(0.000234);
  }
  void AutonomousPeriodic() override {
    left.Set(0.25 + leftLoop.Calculate(leftEncoder.GetRate(), 1.0));
    right.Set(0.25 + rightLoop.Calculate(rightEncoder.GetRate(), 0.95));
  }
  void DisabledPeriodic() override {
    left.Set(0.0);
    right.Set(0.0);
  }
};

int main() { return frc::StartRobot<Robot>(); }
