// Swerve on PWM with analog encoders on the azimuths: drives a slalom by loops of its own.
#include <cmath>

#include <frc/AnalogEncoder.h>
#include <frc/Encoder.h>
#include <frc/TimedRobot.h>
#include <frc/motorcontrol/PWMSparkMax.h>

constexpr double kPi = 3.141592653589793;

struct Module {
  frc::PWMSparkMax drive, steer;
  frc::Encoder wheel;
  frc::AnalogEncoder azimuth;
  explicit Module(int k) : drive(2 * k), steer(2 * k + 1), wheel(2 * k, 2 * k + 1), azimuth(k) {
    wheel.SetDistancePerPulse(0.319186 / 2048.0);
  }
  void Go(double speed, double angle) {
    double error = std::remainder(angle / (2.0 * kPi) - azimuth.Get(), 1.0);
    double rate = wheel.GetRate();
    steer.Set(std::fmax(-1.0, std::fmin(1.0, 4.0 * error)));
    drive.Set(speed / 4.5 + 0.2 * (speed - rate));
  }
};

class Robot : public frc::TimedRobot {
  Module modules[4] = {Module(0), Module(1), Module(2), Module(3)};
  int loops = 0;

 public:
  void AutonomousPeriodic() override {
    double time = 0.02 * loops++;
    double angle = 0.6 * std::sin(0.8 * time);
    for (int k = 0; k < 4; k++) modules[k].Go(1.5, angle);
  }
  void DisabledPeriodic() override {
    for (int k = 0; k < 4; k++) { modules[k].drive.Set(0.0); modules[k].steer.Set(0.0); }
  }
};

int main() { return frc::StartRobot<Robot>(); }
