"""Images that stay on the device, refined while nothing moves, within a budget."""
