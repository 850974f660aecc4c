"""Signal Temporal Logic: formulas over sampled signals and how robustly they hold."""
