// SPDX-License-Identifier: Apache-2.0
#include "geometry/sfm/tracks.h"

#include <algorithm>
#include <numeric>
#include <random>
#include <utility>

namespace uwv::sfm {

PairMatches matches_between(const std::vector<Track>& tracks, int frame_a, int frame_b) {
  PairMatches out;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    if (!tracks[t].in(frame_a) || !tracks[t].in(frame_b)) continue;
    out.track.push_back(static_cast<int>(t));
    out.a.push_back(tracks[t].at(frame_a));
    out.b.push_back(tracks[t].at(frame_b));
  }
  return out;
}

std::vector<Track> tracks_of_shot(const TrackedClip& clip, int begin, int end) {
  std::vector<Track> out;
  for (const Track& track : clip.tracks) {
    if (track.first < begin || track.end() > end || track.pixels.size() < 2) continue;
    out.push_back(track);
    out.back().first -= begin;
  }
  return out;
}

std::vector<std::size_t> drawing_order(std::size_t count, std::uint64_t seed) {
  std::vector<std::size_t> out(count);
  std::iota(out.begin(), out.end(), std::size_t{0});
  std::mt19937_64 random(seed);
  for (std::size_t i = count; i > 1; --i) std::swap(out[i - 1], out[random() % i]);
  return out;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace uwv::sfm
