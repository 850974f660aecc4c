"""What robots sense: mounts, one vocabulary of noise, and sensors that read the state of a world."""
