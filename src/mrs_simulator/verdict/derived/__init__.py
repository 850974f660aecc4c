"""What a law is, found by asking it, and the theory that follows from that."""
