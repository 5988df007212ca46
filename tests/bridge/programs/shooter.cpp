// A robot of REBUILT: backs into the depot with its intake on, drives out, turns to the hub and shoots what it holds.
#include <cmath>

#include <frc/ADIS16448_IMU.h>
#include <frc/DigitalInput.h>
#include <frc/Encoder.h>
#include <frc/TimedRobot.h>
#include <frc/motorcontrol/PWMSparkMax.h>
#include <frc/smartdashboard/SendableChooser.h>
#include <frc/smartdashboard/SmartDashboard.h>

class Robot : public frc::TimedRobot {
  frc::PWMSparkMax left{0}, right{1}, roller{2}, feeder{3}, wheel{4}, secondWheel{5};
  frc::Encoder leftEncoder{0, 1}, rightEncoder{2, 3}, wheelEncoder{4, 5};
  frc::DigitalInput hasNoFuel{6};
  frc::ADIS16448_IMU gyro;
  frc::SendableChooser<double> chooser;
  double goal = 0.0;
  int loops = 0, empty = 0;

  void Drive(double speed, double heading) {  // [m/s], and degrees to the left
    double turn = 0.03 * (heading - gyro.GetAngle().value());
    turn = std::fmax(-0.25, std::fmin(0.25, turn));
    double rate = 0.5 * (leftEncoder.GetRate() + rightEncoder.GetRate());
    double forward = speed / 4.6 + 0.2 * (speed - rate);
    left.Set(forward - turn);
    right.Set(forward + turn);
  }

  void Spin(double turnsPerSecond) {
    double volts = turnsPerSecond * 12.0 / 113.0 + 0.3 * (turnsPerSecond - wheelEncoder.GetRate());
    double output = turnsPerSecond == 0.0 ? 0.0 : std::fmax(0.0, std::fmin(12.0, volts)) / 12.0;
    wheel.Set(output);
    secondWheel.Set(output);
  }

 public:
  Robot() {
    right.SetInverted(true);
    leftEncoder.SetDistancePerPulse(0.479 / 2048.0);
    rightEncoder.SetDistancePerPulse(0.479 / 2048.0);
    wheelEncoder.SetDistancePerPulse(1.0 / 2048.0);
    chooser.SetDefaultOption("nothing", 0.0);
    chooser.AddOption("depot", 45.0);
    frc::SmartDashboard::PutData("Auto", &chooser);
  }

  void AutonomousInit() override {
    loops = empty = 0;
    goal = chooser.GetSelected();
  }

  void AutonomousPeriodic() override {
    double time = 0.02 * loops++, way = 0.5 * (leftEncoder.GetDistance() + rightEncoder.GetDistance());
    if (goal == 0.0) return;
    bool takesIn = time < 4.5;
    roller.Set(takesIn ? 0.9 : 0.0);
    if (takesIn) Drive(way > -1.1 ? -0.8 : 0.0, 4.0 * std::sin(3.0 * time));
    else if (time < 6.5) Drive(way < 0.4 ? 1.2 : 0.0, 0.0);
    else Drive(0.0, -39.4);
    Spin(time > 5.0 ? goal : 0.0);
    bool isReady = std::fabs(wheelEncoder.GetRate() - goal) < 2.0;
    feeder.Set(time > 8.5 && isReady ? 0.9 : 0.0);
  }

  void DisabledPeriodic() override {
    for (auto motor : {&left, &right, &roller, &feeder, &wheel, &secondWheel}) motor->Set(0.0);
  }
};

int main() { return frc::StartRobot<Robot>(); }
