"""Arms on wheeled bases: models, kinematics, and the motion of tools by base and arm."""
