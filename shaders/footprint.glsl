// SPDX-License-Identifier: Apache-2.0
// The footprint of rasterizer.h: which target pixels a point covers.

uniform sampler2D slope_map;  // RG32F
uniform bool has_slopes;
uniform float point_size;
uniform float min_footprint;
uniform float max_footprint;

struct Footprint {
  bool drawn;
  float z;
  ivec4 covered;  // x0, y0, x1, y1, all inside the target; nothing when not drawn
};

// Column `c` of the warp's Jacobian in one row.
float jacobian(int row, int c, float z, float slope, float position, float across, float inverse_depth) {
  precise float along = z * warp_a[3 * row + c] + warp_b[row] * slope;
  precise float result = (along - position * across) * inverse_depth;
  return result;
}

float half_side(float j0, float j1) {
  precise float side = point_size * (abs(j0) + abs(j1)) / 2.0;
  return side;
}

Footprint footprint(ivec2 source) {
  Footprint nothing = Footprint(false, 0.0, ivec4(0, 0, -1, -1));
  float z = texelFetch(depth_map, source, 0).r;
  Moved p = move_point(source, z);
  if (!p.drawn) return nothing;
  vec2 slope = has_slopes ? texelFetch(slope_map, source, 0).rg : vec2(0.0);
  precise float inverse = 1.0 / p.z;
  precise float across_x = z * warp_a[6] + warp_b[2] * slope.x;
  precise float across_y = z * warp_a[7] + warp_b[2] * slope.y;
  float hx = half_side(jacobian(0, 0, z, slope.x, p.u, across_x, inverse), jacobian(0, 1, z, slope.y, p.u, across_y, inverse));
  float hy = half_side(jacobian(1, 0, z, slope.x, p.v, across_x, inverse), jacobian(1, 1, z, slope.y, p.v, across_y, inverse));
  if (!is_number(hx) || !is_number(hy)) return nothing;
  hx = clamp(hx, min_footprint / 2.0, max_footprint / 2.0);
  hy = clamp(hy, min_footprint / 2.0, max_footprint / 2.0);
  precise float x0 = ceil(p.u - (hx + 0.5));
  precise float y0 = ceil(p.v - (hy + 0.5));
  precise float x1 = ceil(p.u + (hx - 0.5)) - 1.0;
  precise float y1 = ceil(p.v + (hy - 0.5)) - 1.0;
  vec2 last = vec2(target_size - 1);
  // Before converting: positions may be far outside what an int holds.
  if (!(x0 <= last.x && y0 <= last.y && x1 >= 0.0 && y1 >= 0.0)) return nothing;
  x0 = max(x0, 0.0);
  y0 = max(y0, 0.0);
  x1 = min(x1, last.x);
  y1 = min(y1, last.y);
  return Footprint(x0 <= x1 && y0 <= y1, p.z, ivec4(x0, y0, x1, y1));
}

// Visits the covered pixels in one loop instead of two nested ones: where neighbouring points share a SIMD register
// (llvmpipe), nested loops run for the tallest times the widest footprint. Measured a fifth faster there.
struct Walk {
  int pixel;  // index into the target, row by row
  int last;
  int row_end;
  int width;
};

Walk walk_over(ivec4 covered) {
  Walk walk;
  walk.pixel = covered.y * target_size.x + covered.x;
  walk.last = covered.w * target_size.x + covered.z;
  walk.width = covered.z - covered.x;
  walk.row_end = walk.pixel + walk.width;
  return walk;
}

void advance(inout Walk walk) {
  if (walk.pixel < walk.row_end) {
    ++walk.pixel;
  } else {
    walk.row_end += target_size.x;
    walk.pixel = walk.row_end - walk.width;
  }
}
