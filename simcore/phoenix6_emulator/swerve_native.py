"""The native functions of `phoenix6.swerve`, by name: marshalling, and nothing else."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import partial
from types import SimpleNamespace
from typing import Any, TypeAlias

from simcore.phoenix6_emulator.emulated_drivetrain import (
    Brake,
    Centric,
    DrivetrainConstants,
    DrivetrainRequest,
    DrivetrainState,
    EmulatedDrivetrain,
    Idle,
    ModuleConstants,
    ModuleDevices,
    Point,
    Speeds,
    wrap,
)
from simcore.phoenix6_emulator.emulator import Emulator
from simcore.phoenix6_emulator.native_library import (
    FIELDS,
    PREFIX,
    Held,
    NativeLibrary,
    python_function,
    record,
    target_of,
)

__all__ = ["SwerveNative"]

_PREFIX = PREFIX + "swerve_"
_OK = 0
_INVALID = -11100  # any error code: the drivetrain is closed


class _Custom:
    """A request written in Python, by the team or in phoenix6 itself."""

    def __init__(self, callback: Any) -> None:
        self._function = python_function(callback)

    def apply(self, drivetrain: EmulatedDrivetrain) -> None:
        vx, vy, omega = drivetrain.chassis_speeds
        x, y, theta = drivetrain.estimator.pose
        parameters = record(
            {FIELDS.current: SimpleNamespace(vx=vx, vy=vy, omega=omega)},
            kMaxSpeedMps=drivetrain.max_speed,
            operatorForwardDirection=drivetrain.operator_forward,
            currentPose=SimpleNamespace(x=x, y=y, theta=theta),
            timestamp=drivetrain.now,
            updatePeriod=drivetrain.period,
        )
        self._function(None, Held(parameters))


class SwerveNative(NativeLibrary):
    """In place of the library that holds swerve: all drivetrains, and the functions by which phoenix6 reaches them.

    Args:
        emulator: The devices; its steps drive odometry.
    """

    def __init__(self, emulator: Emulator) -> None:
        self._emulator = emulator
        self._drivetrains: dict[int, EmulatedDrivetrain] = {}
        self._constants: dict[int, Any] = {}
        self._handles = itertools.count(1)
        self._ids = itertools.count(1)
        self._cancel: dict[int, Callable[[], None]] = {}
        for name in dir(type(self)):
            if name.startswith(_FAMILIES):
                setattr(self, _PREFIX + name, getattr(self, name))
        for name, make in _REQUESTS.items():
            setattr(self, f"{_PREFIX}drivetrain_set_control_{name}", partial(self._set, make))
            setattr(self, f"{_PREFIX}request_apply_{name}", partial(self._apply, make))

    def reset(self) -> None:
        """Remove all drivetrains, as for a fresh test."""
        self._drivetrains.clear()
        self._constants.clear()
        self._cancel.clear()

    # ---- building

    def create_drivetrain_constants(self, can_bus: Any, pigeon_id: int) -> int:
        handle = next(self._handles)
        self._constants[handle] = DrivetrainConstants(getattr(can_bus, "value", can_bus).decode(), pigeon_id)
        return handle

    def create_module_constants_arr(self, count: int) -> int:
        handle = next(self._handles)
        self._constants[handle] = [None] * count
        return handle

    def set_module_constants(self, handle: int, index: int, *values: Any) -> None:
        self._constants[handle][index] = ModuleConstants(*values)

    def create_drivetrain(self, constants: int, modules: int, count: int) -> int:
        return self._create(constants, modules, 0.0)

    def create_drivetrain_with_freq(self, constants: int, hz: float, modules: int, count: int) -> int:
        return self._create(constants, modules, hz)

    def create_drivetrain_with_stddev(
        self, constants: int, hz: float, state: Any, vision: Any, modules: int, count: int
    ) -> int:
        number = self._create(constants, modules, hz)
        self._drivetrains[number].estimator.set_state_std_devs(target_of(state)[:3])
        self._drivetrains[number].estimator.set_vision_std_devs(target_of(vision)[:3])
        return number

    def _create(self, constants: int, modules: int, hz: float) -> int:
        number = next(self._ids)
        self._drivetrains[number] = EmulatedDrivetrain(self._constants.pop(constants), self._constants.pop(modules), hz)
        return number

    def destroy_drivetrain(self, number: int) -> None:
        self.drivetrain_odom_stop(number)
        self._drivetrains.pop(number, None)

    # ---- odometry

    def drivetrain_odom_start(self, number: int) -> None:
        drivetrain = self._drivetrains[number]
        modules = [ModuleDevices(self._emulator, c) for c in drivetrain.module_constants]
        drivetrain.start(modules, self._emulator.pigeon(drivetrain.constants.pigeon_id))
        if number not in self._cancel:
            clock = self._emulator.clock
            self._cancel[number] = self._emulator.every(drivetrain.period, lambda: drivetrain.update(clock.now))

    def drivetrain_odom_stop(self, number: int) -> None:
        if number in self._cancel:
            self._cancel.pop(number)()
            self._drivetrains[number].stop()

    def drivetrain_odom_set_thread_priority(self, number: int, priority: int) -> None:
        """There is no thread."""

    def drivetrain_is_on_can_fd(self, number: int) -> bool:
        return True

    def drivetrain_get_odometry_frequency(self, number: int) -> float:
        return self._drivetrains[number].hz

    def drivetrain_is_odometry_valid(self, number: int) -> bool:
        return self._drivetrains[number].is_running

    def drivetrain_get_state(self, number: int, out: Any) -> None:
        _fill(target_of(out), self._drivetrains[number].state)

    def drivetrain_register_telemetry(self, number: int, context: Any, callback: Any = None) -> None:
        drivetrain = self._drivetrains[number]
        if callback is None:
            drivetrain.on_state = None
            return
        function = python_function(callback)
        drivetrain.on_state = lambda state: function(None, Held(_plain(state)))

    # ---- resets and vision

    def drivetrain_tare_everything(self, number: int) -> None:
        self._drivetrains[number].tare_everything()

    def drivetrain_seed_field_centric(self, number: int, heading: float) -> None:
        self._drivetrains[number].seed_field_centric(heading)

    def drivetrain_reset_pose(self, number: int, x: float, y: float, heading: float) -> None:
        self._drivetrains[number].reset_pose((x, y, heading))

    def drivetrain_reset_translation(self, number: int, x: float, y: float) -> None:
        self._drivetrains[number].reset_translation(x, y)

    def drivetrain_reset_rotation(self, number: int, heading: float) -> None:
        self._drivetrains[number].reset_rotation(heading)

    def drivetrain_set_operator_forward_direction(self, number: int, direction: float) -> None:
        self._drivetrains[number].operator_forward = direction

    def drivetrain_get_operator_forward_direction(self, number: int) -> float:
        return self._drivetrains[number].operator_forward

    def drivetrain_add_vision_measurement(self, number: int, x: float, y: float, heading: float, time: float) -> None:
        self._drivetrains[number].estimator.add_vision((x, y, heading), time)

    def drivetrain_add_vision_measurement_with_stddev(
        self, number: int, x: float, y: float, heading: float, time: float, std_devs: Any
    ) -> None:
        self._drivetrains[number].estimator.add_vision((x, y, heading), time, target_of(std_devs)[:3])

    def drivetrain_set_vision_measurement_stddevs(self, number: int, std_devs: Any) -> None:
        self._drivetrains[number].estimator.set_vision_std_devs(target_of(std_devs)[:3])

    def drivetrain_set_state_stddevs(self, number: int, std_devs: Any) -> None:
        self._drivetrains[number].estimator.set_state_std_devs(target_of(std_devs)[:3])

    def drivetrain_sample_pose_at(self, number: int, time: float, out: Any) -> bool:
        pose = self._drivetrains[number].estimator.sample(time)
        if pose is None:
            return False
        target = target_of(out)
        target.x, target.y, target.theta = pose[0], pose[1], wrap(pose[2])
        return True

    # ---- modules

    def drivetrain_config_neutral_mode(self, number: int, mode: int) -> int:
        return max((m.devices.set_neutral(mode == 1) for m in self._drivetrains[number].modules), default=_OK)

    def drivetrain_config_neutral_mode_with_timeout(self, number: int, mode: int, timeout: float) -> int:
        return self.drivetrain_config_neutral_mode(number, mode)

    def module_apply(self, number: int, index: int, request: Any) -> None:
        r = target_of(request)
        wanted = getattr(r, FIELDS.wanted)
        self._drivetrains[number].modules[index].apply(
            getattr(wanted, FIELDS.module),
            wanted.angle,
            closed_loop=r.driveRequest == 1,
            profiled=r.steerRequest == 0,
            period=r.updatePeriod,
            force_x=r.wheelForceFeedforwardX,
            force_y=r.wheelForceFeedforwardY,
            foc=r.enableFOC,
        )

    def module_get_position(self, number: int, index: int, refresh: bool) -> Any:
        """The present position; reading it does not disturb odometry."""
        module = self._drivetrains[number].modules[index]
        if not refresh:
            return self.module_get_cached_position(number, index)
        distance, angle = module.look()
        return SimpleNamespace(distance=distance, angle=angle)

    def module_get_cached_position(self, number: int, index: int) -> Any:
        module = self._drivetrains[number].modules[index]
        return SimpleNamespace(distance=module.distance, angle=module.angle)

    def module_get_current_velocity(self, number: int, index: int) -> Any:
        module = self._drivetrains[number].modules[index]
        return _velocity(module.speed, module.angle)

    def module_get_target_velocity(self, number: int, index: int) -> Any:
        return _velocity(*self._drivetrains[number].modules[index].target)

    def module_reset_target_velocity(self, number: int, index: int) -> None:
        self._drivetrains[number].modules[index].target = (0.0, 0.0)

    def module_reset_position(self, number: int, index: int) -> None:
        self._drivetrains[number].modules[index].zero()

    # ---- requests

    def drivetrain_set_control(self, number: int, context: Any, callback: Any = None) -> None:
        self._drivetrains[number].request = Idle() if callback is None else _Custom(callback)

    def _set(self, make: _MakeRequest, number: int, *values: Any) -> None:
        self._drivetrains[number].request = make(*values)

    def _apply(self, make: _MakeRequest, number: int, *values: Any) -> int:
        drivetrain = self._drivetrains.get(number)
        if drivetrain is None:
            return _INVALID
        make(*values).apply(drivetrain)
        return _OK


_FAMILIES = ("create_", "set_module", "destroy_", "drivetrain_", "module_")


def _speeds(values: tuple[Any, ...], *, is_field: bool) -> Speeds:
    vx, vy, omega, forces_x, count_x, forces_y, count_y, *rest = values
    return Speeds(vx, vy, omega, tuple(forces_x[:count_x]), tuple(forces_y[:count_y]), *rest, is_field=is_field)


_MakeRequest: TypeAlias = Callable[..., DrivetrainRequest]
_REQUESTS: dict[str, _MakeRequest] = {
    "idle": Idle,
    "swerve_drive_brake": Brake,
    "field_centric": partial(Centric, is_field=True),
    "robot_centric": Centric,
    "point_wheels_at": Point,
    "apply_robot_velocity": lambda *values: _speeds(values, is_field=False),
    "apply_field_velocity": lambda *values: _speeds(values, is_field=True),
}
"""What the native functions make of a request's numbers, by their last words."""


def _velocity(speed: float, angle: float) -> SimpleNamespace:
    return record({FIELDS.module: speed}, angle=angle)


def _plain(state: DrivetrainState) -> SimpleNamespace:
    """The state with the names of the native struct."""
    vx, vy, omega = state.speeds
    return record(
        {
            FIELDS.chassis: SimpleNamespace(vx=vx, vy=vy, omega=omega),
            FIELDS.modules: [_velocity(s, a) for s, a in state.states],
        },
        pose=SimpleNamespace(x=state.pose[0], y=state.pose[1], theta=state.pose[2]),
        moduleTargets=[_velocity(s, a) for s, a in state.targets],
        modulePositions=[SimpleNamespace(distance=d, angle=a) for d, a in state.positions],
        rawHeading=state.raw_heading,
        timestamp=state.timestamp,
        odometryPeriod=state.period,
        successfulDaqs=state.samples,
        failedDaqs=0,
    )


def _fill(out: Any, state: DrivetrainState) -> None:
    """Write the state into a `SwerveDriveState_t`."""
    pose, speeds = out.pose, getattr(out, FIELDS.chassis)
    pose.x, pose.y, pose.theta = state.pose
    speeds.vx, speeds.vy, speeds.omega = state.speeds
    states, targets, positions = getattr(out, FIELDS.modules), out.moduleTargets, out.modulePositions
    for items, values in ((states, state.states), (targets, state.targets)):
        for k, (speed, angle) in enumerate(values):
            item = items[k]
            setattr(item, FIELDS.module, speed)
            item.angle = angle
    for k, (distance, angle) in enumerate(state.positions):
        item = positions[k]
        item.distance, item.angle = distance, angle
    out.rawHeading = state.raw_heading
    out.timestamp = state.timestamp
    out.odometryPeriod = state.period
    out.successfulDaqs = state.samples
    out.failedDaqs = 0
