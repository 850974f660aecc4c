"""Commands of vehicles' own firmware, as functions of arrays."""
