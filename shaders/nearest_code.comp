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
  for (int y = point.covered.y; y <= point.covered.w; ++y)
    for (int x = point.covered.x; x <= point.covered.z; ++x) {
      int pixel = y * target_size.x + x;
      if (bits == depth_bits[pixel]) atomicMin(winners[pixel], code);
    }
}
