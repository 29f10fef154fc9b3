// SPDX-License-Identifier: Apache-2.0
// Second pass of the compute z-buffer: of the points at the smallest depth, the lowest code.

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Depths { uint depth_bits[]; };
layout(std430, binding = 1) buffer Winners { uint winners[]; };

void main() {
  ivec2 source = ivec2(gl_GlobalInvocationID.xy);
  if (source.x >= source_size.x) return;
  Footprint point = footprint(source);
  if (!point.drawn) return;
  uint bits = floatBitsToUint(point.z);
  uint code = uint(source.y) << 16 | uint(source.x);
  for (Walk walk = walk_over(point.covered); walk.pixel <= walk.last; advance(walk)) {
    if (bits == depth_bits[walk.pixel]) atomicMin(winners[walk.pixel], code);
  }
}
