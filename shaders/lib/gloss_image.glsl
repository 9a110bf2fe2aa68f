// What the G-buffer keeps of gloss: of what reflects, lib/brdf.glsl, and of how far images in it may be
// filtered, lib/edge_aware_filter.glsl.
uniform sampler2D t_gloss;  // rgb: reflectance at normal incidence, a: roughness
