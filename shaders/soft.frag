// SPDX-License-Identifier: Apache-2.0
// The bilinear part of one pixel's weight. A position that is an integer is its own floor and ceiling: the reference
// then counts the pixel twice, and so do we.

flat in vec2 position;
flat in vec4 colour_and_weight;
flat in float weighted_depth;
layout(location = 0) out vec4 colour_sum;
layout(location = 1) out float depth_sum;

void main() {
  vec2 canvas = floor(gl_FragCoord.xy) + 1.0;
  vec2 first = floor(position);
  vec2 second = ceil(position);
  precise vec2 near_first = 1.0 - (position - first);
  precise vec2 near_second = 1.0 - (second - position);
  vec2 share = vec2(equal(canvas, first)) * near_first + vec2(equal(canvas, second)) * near_second;
  float weight = share.x * share.y;
  if (!(weight > 0.0)) discard;
  colour_sum = colour_and_weight * weight;
  depth_sum = weighted_depth * weight;
}
