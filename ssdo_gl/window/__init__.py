"""The interactive window: input, views, overlay."""
