"""A team's own simulation, which knows nothing of simcore."""


class PhysicsEngine:
    def __init__(self, physics_controller, robot) -> None:
        robot.their_physics = self
        self.calls = 0

    def update_sim(self, now: float, tm_diff: float) -> None:
        self.calls += 1
