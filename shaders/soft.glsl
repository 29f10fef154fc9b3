// SPDX-License-Identifier: Apache-2.0
// The reference's soft z-test (SoftSplatOptions in rasterizer.h).

uniform sampler2D colour_map;  // RGB32F
uniform bool has_colour;
uniform float sharpness;
uniform float log_depth_max;

struct SoftPoint {
  bool drawn;
  float z;
  float weight;        // without the bilinear part
  vec2 position;       // on the reference's canvas: integer pixel centres, one pixel of padding around the picture
  vec2 first, second;  // floor and ceiling of position: the four pixels around it
};

SoftPoint soft_point(ivec2 source) {
  Moved p = move_point(source, texelFetch(depth_map, source, 0).r);
  SoftPoint point;
  point.drawn = p.drawn;
  point.z = p.z;
  float share = log_depth_max > 0.0 ? log(1.0 + min(p.z, 1000.0)) / log_depth_max : 0.0;
  point.weight = 1.0 / exp(sharpness * share);
  precise vec2 position = clamp(vec2(p.u, p.v) + 0.5, vec2(0.0), vec2(target_size + 1));
  point.position = position;
  point.first = floor(position);
  point.second = ceil(position);
  return point;
}

vec3 colour_of(ivec2 source) { return has_colour ? texelFetch(colour_map, source, 0).rgb : vec3(0.0); }
