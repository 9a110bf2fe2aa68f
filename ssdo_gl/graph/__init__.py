"""The frame graph: which passes run, in what order, and what is kept between frames."""
