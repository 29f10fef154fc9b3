// SPDX-License-Identifier: Apache-2.0
// Marks the covered pixels; no depth test.

flat in ivec4 covered;
layout(location = 0) out uint is_covered;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  if (any(lessThan(pixel, covered.xy)) || any(greaterThan(pixel, covered.zw))) discard;
  is_covered = 1u;
}
