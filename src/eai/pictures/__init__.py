"""Scene graphs, and pictures of scenes: what is described of a scene, drawn as a plan of its rooms."""
