"""Arms on wheeled bases: which there are, how they move, and how base and arm move a tool together."""
