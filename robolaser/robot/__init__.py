"""The arm: kinematics, gravity torques, collisions, visibility; arms that are known by name."""
