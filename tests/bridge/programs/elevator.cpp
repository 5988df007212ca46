// An elevator that finds its lower limit switch, then its upper one, and then holds four turns of its drum.
#include <algorithm>

#include <frc/DigitalInput.h>
#include <frc/Encoder.h>
#include <frc/TimedRobot.h>
#include <frc/motorcontrol/PWMSparkMax.h>

class Robot : public frc::TimedRobot {
  frc::PWMSparkMax motor{3};
  frc::Encoder encoder{6, 7};
  frc::DigitalInput low{4}, high{5};
  enum { kDown, kUp, kHold } state = kDown;
  int loops = 0;  // at the lower switch, until it stands

 public:
  Robot() { encoder.SetDistancePerPulse(1.0 / 2048.0); }
  void AutonomousPeriodic() override {
    if (state == kDown && !low.Get() && loops++ > 25) {
      encoder.Reset();
      state = kUp;
    }
    if (state == kUp && !high.Get()) state = kHold;
    double goal = 0.1 + 0.5 * (4.0 - encoder.GetDistance());
    motor.Set(state == kDown ? -0.1 : state == kUp ? 0.5 : std::max(-0.3, std::min(0.5, goal)));
  }
  void DisabledPeriodic() override { motor.Set(0.0); }
};

int main() { return frc::StartRobot<Robot>(); }
