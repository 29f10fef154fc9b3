// SPDX-License-Identifier: Apache-2.0
// First pass of the compute z-buffer: the smallest depth of each target pixel. Positive floats order like their bits.

layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Depths { uint depth_bits[]; };

void main() {
  ivec2 source = ivec2(gl_GlobalInvocationID.xy);
  if (source.x >= source_size.x) return;
  Footprint point = footprint(source);
  if (!point.drawn) return;
  uint bits = floatBitsToUint(point.z);
  for (Walk walk = walk_over(point.covered); walk.pixel <= walk.last; advance(walk)) atomicMin(depth_bits[walk.pixel], bits);
}
