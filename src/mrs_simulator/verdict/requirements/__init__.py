"""Requirements on runs: formulas that a scenario states beside the claims of its protocol."""
