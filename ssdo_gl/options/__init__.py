"""What a user chose: flags, presets, settings of passes; checked, and filled in for a scene."""
