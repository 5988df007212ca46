// An arm with a potentiometer, to and fro between two angles by a proportional loop.
#include <frc/AnalogPotentiometer.h>
#include <frc/TimedRobot.h>
#include <frc/motorcontrol/PWMSparkMax.h>

class Robot : public frc::TimedRobot {
  frc::PWMSparkMax motor{2};
  frc::AnalogPotentiometer pot{1, 5.0, 0.0};
  int loops = 0;

 public:
  void AutonomousPeriodic() override {
    double goal = loops++ % 200 < 100 ? 3.0 : 1.5;
    motor.Set(0.4 * (goal - pot.Get()));
  }
  void DisabledPeriodic() override { motor.Set(0.0); }
};

int main() { return frc::StartRobot<Robot>(); }
