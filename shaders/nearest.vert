// SPDX-License-Identifier: Apache-2.0
// One sprite per source pixel; no vertex data, everything is fetched by the vertex's number.

const float exp2_minus_40 = 1.0 / 1099511627776.0;  // max_depth becomes less than 1, and nothing is rounded

flat out ivec4 covered;
flat out float scaled_depth;
flat out uint code;

void main() {
  ivec2 source = source_of_vertex();
  Footprint point = footprint(source);
  covered = point.covered;
  scaled_depth = point.z * exp2_minus_40;
  code = uint(source.y) << 16 | uint(source.x);
  if (point.drawn)
    place_sprite(point.covered);
  else
    place_nothing();
}
