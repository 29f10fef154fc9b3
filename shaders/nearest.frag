// SPDX-License-Identifier: Apache-2.0
// Depth is written here rather than in clip space, where the mapping to [0, 1] would round it.

flat in ivec4 covered;
flat in float scaled_depth;
flat in uint code;
layout(location = 0) out uint winner;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  if (any(lessThan(pixel, covered.xy)) || any(greaterThan(pixel, covered.zw))) discard;
  gl_FragDepth = scaled_depth;
  winner = code;
}
