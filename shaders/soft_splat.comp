// SPDX-License-Identifier: Apache-2.0
// Adds each point to its four pixels. Sums are planes of their own, so that an 8K picture fits a storage block.

layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Weights { float weights[]; };
layout(std430, binding = 1) buffer Depths { float depths[]; };
layout(std430, binding = 2) buffer Reds { float reds[]; };
layout(std430, binding = 3) buffer Greens { float greens[]; };
layout(std430, binding = 4) buffer Blues { float blues[]; };

void add(vec2 corner, float weight, float z, vec3 colour) {
  if (any(lessThan(corner, vec2(1.0))) || any(greaterThan(corner, vec2(target_size)))) return;
  int pixel = (int(corner.y) - 1) * target_size.x + int(corner.x) - 1;
  atomicAdd(weights[pixel], weight);
  atomicAdd(depths[pixel], z * weight);
  if (!has_colour) return;
  atomicAdd(reds[pixel], colour.r * weight);
  atomicAdd(greens[pixel], colour.g * weight);
  atomicAdd(blues[pixel], colour.b * weight);
}

void main() {
  ivec2 source = ivec2(gl_GlobalInvocationID.xy);
  if (source.x >= source_size.x) return;
  SoftPoint p = soft_point(source);
  if (!p.drawn) return;
  vec3 colour = colour_of(source);
  precise vec2 near_first = 1.0 - (p.position - p.first);
  precise vec2 near_second = 1.0 - (p.second - p.position);
  add(p.first, near_first.y * near_first.x * p.weight, p.z, colour);
  add(vec2(p.first.x, p.second.y), near_second.y * near_first.x * p.weight, p.z, colour);
  add(vec2(p.second.x, p.first.y), near_first.y * near_second.x * p.weight, p.z, colour);
  add(p.second, near_second.y * near_second.x * p.weight, p.z, colour);
}
