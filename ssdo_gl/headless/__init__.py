"""What people run without a window: snapshots and explanations."""
