// SPDX-License-Identifier: Apache-2.0
// The warp of point_grid.h, shared by every shader. `precise` keeps the compiler from fusing or reordering, so that the
// CPU renderer gets the same bits.

uniform sampler2D depth_map;  // R32F; 0 = no point (invalid or masked)
uniform ivec2 source_size;
uniform ivec2 target_size;
uniform float warp_a[9];  // row-major, half-pixel shift folded in
uniform float warp_b[3];

const float max_depth = 1e12;

// Comparing bits instead of values: compilers may assume that numbers are never NaN.
bool is_number(float value) { return (floatBitsToUint(value) & 0x7FFFFFFFu) <= 0x7F800000u; }

struct Moved {
  bool drawn;
  float u, v;  // pixel position in the target
  float z;     // depth in the target
};

Moved move_point(ivec2 source, float z) {
  float x = float(source.x);
  float y = float(source.y);
  precise float p[3];
  for (int i = 0; i < 3; ++i) {
    precise float ray = warp_a[3 * i] * x + (warp_a[3 * i + 1] * y + warp_a[3 * i + 2]);
    p[i] = z * ray + warp_b[i];
  }
  precise float u = p[0] / p[2];
  precise float v = p[1] / p[2];
  bool drawn = z > 0.0 && p[2] > 0.0 && p[2] <= max_depth && is_number(p[2]) && is_number(u) && is_number(v);
  return Moved(drawn, u, v, p[2]);
}
