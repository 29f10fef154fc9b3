// SPDX-License-Identifier: Apache-2.0
#include "bench/real_pairs.h"

#include <algorithm>

#include "bench/stereo_pairs.h"

namespace uwv::bench {
namespace {

constexpr int motorcycle_steps = 8;

RealPair pair_of(const TrueClip& clip, const std::string& folder, long from, long to) {
  for (const long index : {from, to})
    if (index < 0 || index >= static_cast<long>(clip.frames.size()))
      fail(ErrorCode::size_mismatch, "{}: has {} frames, the pair wants number {}", folder, clip.frames.size(), index);
  const auto source = static_cast<std::size_t>(from), target = static_cast<std::size_t>(to);
  RealPair pair;
  pair.name = fmt::format("rgbd {}:{}", from, to);
  pair.source = clip.cameras[source];
  pair.colour = clip.frames[source];
  pair.depth = clip.depths[source];
  const long step = to > from ? 1 : -1;
  for (long i = from; i != to; i += step) pair.path.push_back(clip.cameras[static_cast<std::size_t>(i + step)]);
  pair.truth = clip.frames[target];
  pair.truth_depth = clip.depths[target];
  return pair;
}

}  // namespace

RealPair motorcycle_pair(const std::string& folder, const ResizePolicy& resize) {
  TrueClip clip = read_stereo_pair(folder, resize);
  const Camera &left = clip.cameras[0], &right = clip.cameras[1];
  RealPair pair;
  pair.name = "motorcycle";
  pair.source = left;
  pair.colour = std::move(clip.frames[0]);
  pair.depth = std::move(clip.depths[0]);
  for (int k = 1; k <= motorcycle_steps; ++k) {
    const double share = static_cast<double>(k) / motorcycle_steps;
    Camera camera = left;
    camera.intrinsics.cx += share * (right.intrinsics.cx - left.intrinsics.cx);
    camera.world_from_cam.translation = share * right.world_from_cam.translation;
    pair.path.push_back(camera);
  }
  pair.truth = std::move(clip.frames[1]);
  return pair;
}

std::vector<RealPair> rgbd_pairs(const std::string& folder, const std::vector<std::pair<long, long>>& pairs,
                                 const ResizePolicy& resize) {
  long last = 0;
  for (const auto& [from, to] : pairs) last = std::max({last, from, to});
  FrameRange range;
  range.max_frames = last + 1;
  const TrueClip clip = read_true_clip(folder, range, resize);
  std::vector<RealPair> all;
  all.reserve(pairs.size());
  for (const auto& [from, to] : pairs) all.push_back(pair_of(clip, folder, from, to));
  return all;
}

}  // namespace uwv::bench
