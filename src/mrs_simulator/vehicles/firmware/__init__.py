"""What vehicles' own firmware makes of the commands that its users know, as functions of arrays."""
