// SPDX-License-Identifier: Apache-2.0
// Marks every target pixel some footprint covers. Whoever writes, writes the same: no atomics needed.

layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer Covered { uint covered[]; };

void main() {
  ivec2 source = ivec2(gl_GlobalInvocationID.xy);
  if (source.x >= source_size.x) return;
  Footprint point = footprint(source);
  if (!point.drawn) return;
  for (Walk walk = walk_over(point.covered); walk.pixel <= walk.last; advance(walk)) covered[walk.pixel] = 1u;
}
