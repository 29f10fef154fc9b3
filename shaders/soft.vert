// SPDX-License-Identifier: Apache-2.0
// One sprite of at most 2x2 pixels per source pixel, for additive blending.

flat out vec2 position;
flat out vec4 colour_and_weight;  // colour times weight, and weight, without the bilinear part
flat out float weighted_depth;

void main() {
  ivec2 source = source_of_vertex();
  SoftPoint p = soft_point(source);
  position = p.position;
  colour_and_weight = vec4(colour_of(source), 1.0) * p.weight;
  weighted_depth = p.z * p.weight;
  ivec2 low = max(ivec2(p.first) - 1, ivec2(0));
  ivec2 high = min(ivec2(p.second) - 1, target_size - 1);
  if (p.drawn && all(lessThanEqual(low, high)))
    place_sprite(ivec4(low, high));
  else
    place_nothing();
}
