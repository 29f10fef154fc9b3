// SPDX-License-Identifier: Apache-2.0
// Places a point sprite over a rectangle of target pixels.

// The sprite is centred on the rectangle, which lies inside the picture: OpenGL would drop a point whose own centre is
// outside, even if its footprint reaches in.
void place_sprite(ivec4 covered) {
  vec2 low = vec2(covered.xy);
  vec2 high = vec2(covered.zw + 1);
  gl_Position = vec4((low + high) / vec2(target_size) - 1.0, 0.0, 1.0);
  gl_PointSize = max(high.x - low.x, high.y - low.y);
}

// Outside the clip volume: nothing is drawn.
void place_nothing() {
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = 1.0;
}

ivec2 source_of_vertex() { return ivec2(gl_VertexID % source_size.x, gl_VertexID / source_size.x); }
