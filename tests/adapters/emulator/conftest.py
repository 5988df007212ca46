"""Phoenix 6 in simulated time in this process; the library gets its native side back after every test."""

import json
import math
from pathlib import Path

import pytest

DATA = Path(__file__).resolve().parents[1] / "data" / "phoenix6_26.3.0.json"


@pytest.fixture(scope="session")
def recorded():
    """Return the behavior of CTRE's simulation, recorded on the wall clock."""
    return json.loads(DATA.read_text())


class Bench:
    """Motors on a bench, each with an optional flywheel; robot code runs at 50 Hz and physics at 200 Hz."""

    def __init__(self, emulator):
        from phoenix6 import CANBus

        self.emulator = emulator
        self.bus = CANBus("rio")
        self.plants = []
        self._devices = []

    def device(self, cls, number, config=None, **settings):
        """Return a configured device without current limits; settings are `group__name=value`."""
        from phoenix6 import configs, hardware

        device = getattr(hardware, cls)(number, self.bus)
        self._devices.append(device)
        config = config or getattr(configs, f"{cls}Configuration")()
        if cls.startswith("TalonFX"):
            config.current_limits.stator_current_limit_enable = False
            config.current_limits.supply_current_limit_enable = False
        for path, value in settings.items():
            group, name = path.split("__")
            setattr(getattr(config, group), name, value)
        assert device.configurator.apply(config).is_ok()
        return device

    def talon(self, number=1, **settings):
        return self.device("TalonFX", number, **settings)

    def spin(self, talon, inertia=0.002, encoder=None, gearing=1.0):
        """Connect a Kraken X60 with an inertia at the rotor to a controller; return the plant."""
        plant = {"talon": talon, "angle": 0.0, "speed": 0.0, "inertia": inertia, "encoder": encoder, "gearing": gearing}
        self.plants.append(plant)
        return plant

    def hold(self, talon, rotations=0.0, rps=0.0, supply=12.0):
        """Hold a rotor at a position, with a given speed reading."""
        state = talon.sim_state
        state.set_supply_voltage(supply)
        state.set_raw_rotor_position(rotations)
        state.set_rotor_velocity(rps)

    def _physics(self, dt):
        emf, ohm, torque = 12.0 / (5800.0 * math.tau / 60.0), 12.0 / 483.0, 9.37 / 483.0
        for plant in self.plants:
            state = plant["talon"].sim_state
            volts = state.motor_voltage
            if volts != 0.0 or abs(state.torque_current) > 0.5:
                rate, end = emf * torque / ohm / plant["inertia"], volts / emf
                grown = -math.expm1(-rate * dt)
                plant["angle"] += end * dt + (plant["speed"] - end) * grown / rate
                plant["speed"] += (end - plant["speed"]) * grown
            else:
                plant["angle"] += plant["speed"] * dt
            state.set_raw_rotor_position(plant["angle"] / math.tau)
            state.set_rotor_velocity(plant["speed"] / math.tau)
            if plant["encoder"] is not None:
                plant["encoder"].sim_state.set_raw_position(plant["angle"] / math.tau / plant["gearing"])
                plant["encoder"].sim_state.set_velocity(plant["speed"] / math.tau / plant["gearing"])

    def run(self, seconds, each_tick=lambda: None, enabled=True):
        """Advance time; `each_tick` is the robot's periodic method."""
        from phoenix6 import unmanaged

        for k in range(round(seconds / 0.005)):
            unmanaged.feed_enable(0.1 if enabled else 0.0)
            if k % 4 == 0:
                each_tick()
            self.emulator.step(0.005)
            self._physics(0.005)

    def close(self):
        for device in self._devices:
            device.close()


@pytest.fixture
def bench():
    """Yield a bench with fresh devices; the robot is enabled without delay unless a test changes that."""
    pytest.importorskip("phoenix6", reason="needs phoenix6: pip install .[phoenix6]")
    from simcore import season
    from simcore.robotcode.emulator import EnableDelays, install, uninstall

    season.wpilib_simulation.pause_timing()  # the library's enable feed runs on the FPGA clock
    made = Bench(install(delays=EnableDelays(enable=0.0, disable=0.0)))
    yield made
    made.close()
    uninstall()
    season.wpilib_simulation.resume_timing()
