// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/multi_view_stereo.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "geometry/mvs/carry.h"
#include "geometry/mvs/completion.h"
#include "geometry/mvs/consistency.h"
#include "geometry/mvs/edge_snapping.h"
#include "geometry/mvs/view_selection.h"

namespace uwv {
namespace mvs {
namespace {

constexpr float lent_confidence = 0.45F;  // Measured, but not here; more than a filling.
constexpr double scratch_bytes = 512e6;   // Frames in work at once share this much memory for their cost volumes.

/// Steps that were carried, filled or made larger lie beside the picture's edges again. What takes another depth was
/// not confirmed there.
void sharpen(const ImageRgb& frame, RatedDepth& depth) {
  const InverseDepthMap before = depth.inverse_depth;
  snap_to_edges(frame, depth.inverse_depth);
  for (std::size_t i = 0; i < before.size().pixels(); ++i)
    if (depth.inverse_depth.data()[i] != before.data()[i])
      depth.confidence.data()[i] = std::min(depth.confidence.data()[i], lent_confidence);
}

/// One call's work, step by step. Frames are worked on in parallel, each by one thread, so that results do not depend
/// on the number of threads.
class Job {
 public:
  Job(std::span<const ImageRgb> frames, std::span<const Camera> cameras, std::span<const ScenePoint> points,
      std::span<const ValidityMask> masks, const MvsOptions& options, ThreadPool& pool, Monitor& monitor)
      : frames_(frames), masks_(masks), options_(options), pool_(pool), monitor_(monitor) {
    normalisation_ = find_normalisation(cameras, points);
    for (const Camera& camera : cameras) scene_.cameras.push_back(normalisation_.apply(camera));
    for (const ScenePoint& point : points)
      if (point.x_in_world.allFinite()) scene_.points.push_back(normalisation_.apply(point.x_in_world));
    const Size full = frames.front().size();
    size_ = {std::max(1, static_cast<int>(std::lround(full.width * options.scale))),
             std::max(1, static_cast<int>(std::lround(full.height * options.scale)))};
  }

  void run(MvsSummary& summary, std::vector<FrameGeometry>& out) {
    choose_keys(summary);
    choose_views(summary);
    prepare_views();
    match();
    confirm_keys();
    if (options_.complete) lend();
    finish(out);
    measure(summary, out);
  }

 private:
  std::size_t count() const { return frames_.size(); }

  /// Runs body(i) for i = 0..n-1, `width` at a time, and reports after each batch.
  template <class Body>
  void in_batches(std::string_view stage, std::size_t n, std::size_t width, const Body& body) {
    for (std::size_t first = 0; first < n; first += width) {
      const std::size_t batch = std::min(width, n - first);
      pool_.run(static_cast<int>(batch), [&](int part) { body(first + static_cast<std::size_t>(part), part); });
      monitor_.step(stage, static_cast<long>(first + batch), static_cast<long>(n));
    }
  }

  void choose_keys(MvsSummary& summary) {
    if (scene_.points.empty())
      summary.notes.push_back(
          "there are no sparse points: the range of depths was guessed from the cameras' distances");
    const int stride = options_.key_stride > 0 ? options_.key_stride : choose_key_stride(scene_);
    for (std::size_t i = 0; i < count(); i += static_cast<std::size_t>(stride)) keys_.push_back(i);
    if (keys_.back() + 1 != count()) keys_.push_back(count() - 1);
  }

  void choose_views(MvsSummary& summary) {
    neighbours_.resize(keys_.size());
    ranges_.resize(keys_.size());
    pool_.for_ranges(0, static_cast<int>(keys_.size()), 1, [&](int from, int to) {
      for (auto k = static_cast<std::size_t>(from); k < static_cast<std::size_t>(to); ++k) {
        neighbours_[k] = choose_neighbours(scene_, keys_[k], options_.neighbours);
        ranges_[k] = depth_range(scene_, keys_[k]);
      }
    });
    std::size_t alone = 0;
    for (const std::vector<int>& chosen : neighbours_) alone += chosen.empty() ? 1 : 0;
    summary.matched_frames = static_cast<int>(keys_.size() - alone);
    if (count() == 1)
      summary.notes.push_back("one frame has no other to be compared with: all depth is unknown");
    else if (alone == keys_.size())
      summary.notes.push_back("no two cameras are displaced enough for parallax: all depth is unknown");
    else if (alone > 0)
      summary.notes.push_back(
          fmt::format("{} of {} matched frames have no other view with parallax and got no depth of their own", alone,
                      keys_.size()));
  }

  void prepare_views() {
    views_.resize(count());
    in_batches("preparing", count(), 4 * static_cast<std::size_t>(pool_.size()), [&](std::size_t i, int) {
      views_[i] = make_view(frames_[i], scene_.cameras[i], masks_.empty() ? nullptr : &masks_[i], size_);
    });
  }

  std::size_t frames_at_once() const {
    const double bytes = 3.0 * static_cast<double>(size_.pixels()) * (options_.planes + 15);
    const int fitting = std::max(1, static_cast<int>(std::min(scratch_bytes / bytes, 1024.0)));
    return static_cast<std::size_t>(std::min(fitting, pool_.size()));
  }

  void match() {
    struct Scratch {
      CostVolume volume;
      std::vector<std::uint16_t> sums;
    };
    const std::size_t width = frames_at_once();
    std::vector<Scratch> scratch(width);
    matched_.resize(keys_.size());
    in_batches("matching", keys_.size(), width, [&](std::size_t k, int part) {
      if (neighbours_[k].empty()) return;
      std::vector<const View*> others;
      for (const int other : neighbours_[k]) others.push_back(&views_[static_cast<std::size_t>(other)]);
      const View& reference = views_[keys_[k]];
      Scratch& mine = scratch[static_cast<std::size_t>(part)];
      sweep_planes(reference, others, ranges_[k], options_.planes, mine.volume);
      aggregate(mine.volume, reference.grey, mine.sums, matched_[k]);
      snap_to_edges(reference.colour, matched_[k].inverse_depth);
    });
  }

  /// The matched keys nearest to the views a key was compared with.
  std::vector<std::size_t> judges_of(std::size_t k) const {
    std::vector<std::size_t> chosen;
    for (const int neighbour : neighbours_[k]) {
      std::size_t best = k;
      for (std::size_t j = 0; j < keys_.size(); ++j) {
        if (j == k || matched_[j].inverse_depth.empty()) continue;
        const auto distance = [&](std::size_t key) { return std::abs(static_cast<long>(keys_[key]) - neighbour); };
        if (best == k || distance(j) < distance(best)) best = j;
      }
      if (best != k && std::find(chosen.begin(), chosen.end(), best) == chosen.end()) chosen.push_back(best);
    }
    return chosen;
  }

  void confirm_keys() {
    rated_.resize(keys_.size());
    judges_.resize(keys_.size());
    const int smallest = std::max(2, static_cast<int>(size_.pixels() / 4000));
    in_batches("confirming", keys_.size(), 4 * static_cast<std::size_t>(pool_.size()), [&](std::size_t k, int) {
      if (matched_[k].inverse_depth.empty()) {
        rated_[k] = {InverseDepthMap(size_), Image<float>(size_)};
        return;
      }
      std::vector<MatchedView> judges;
      judges_[k] = judges_of(k);
      for (const std::size_t j : judges_[k]) judges.push_back({&views_[keys_[j]], &matched_[j]});
      rated_[k] = confirm({&views_[keys_[k]], &matched_[k]}, judges, options_.consistency);
      remove_speckles(rated_[k], smallest, options_.consistency);
    });
    matched_ = {};
  }

  std::vector<KeyDepth> lenders_of(std::size_t k) const {
    std::vector<std::size_t> from = judges_[k];
    if (k > 0) from.push_back(k - 1);
    if (k + 1 < keys_.size()) from.push_back(k + 1);
    std::vector<KeyDepth> lenders;
    for (const std::size_t j : from) lenders.push_back({&views_[keys_[j]], &rated_[j]});
    return lenders;
  }

  /// What a key could not measure itself, because it lies at the border or is hidden from the other side, neighbouring
  /// keys may have: their depth is a better start for the filling than none.
  void lend() {
    std::vector<RatedDepth> richer(keys_.size());
    in_batches("lending", keys_.size(), 4 * static_cast<std::size_t>(pool_.size()), [&](std::size_t k, int) {
      richer[k] = rated_[k];
      const RatedDepth lent = carry(views_[keys_[k]], lenders_of(k), options_.consistency);
      for (std::size_t i = 0; i < size_.pixels(); ++i) {
        if (richer[k].inverse_depth.data()[i] > 0 || lent.inverse_depth.data()[i] <= 0) continue;
        richer[k].inverse_depth.data()[i] = lent.inverse_depth.data()[i];
        richer[k].confidence.data()[i] = lent_confidence;
      }
    });
    rated_ = std::move(richer);
  }

  RatedDepth depth_of(std::size_t i) const {
    const auto after = std::lower_bound(keys_.begin(), keys_.end(), i);
    const auto k = static_cast<std::size_t>(after - keys_.begin());
    if (*after == i) return rated_[k];
    return carry(views_[i], {{&views_[keys_[k - 1]], &rated_[k - 1]}, {&views_[keys_[k]], &rated_[k]}},
                 options_.consistency);
  }

  void finish(std::vector<FrameGeometry>& out) {
    in_batches("completing", count(), 2 * static_cast<std::size_t>(pool_.size()), [&](std::size_t i, int) {
      RatedDepth depth = depth_of(i);
      if (options_.complete) complete(views_[i], depth);
      RatedDepth full = upsample(views_[i], depth, frames_[i], options_.consistency);
      if (options_.complete) sharpen(frames_[i], full);
      out[i] = to_scene(full, i);
    });
  }

  FrameGeometry to_scene(const RatedDepth& depth, std::size_t i) const {
    FrameGeometry out{DepthMap(frames_[i].size()), ConfidenceMap(frames_[i].size())};
    const bool masked = !masks_.empty() && !masks_[i].empty();
    for (std::size_t p = 0; p < out.depth.size().pixels(); ++p) {
      const float w = depth.inverse_depth.data()[p];
      if (!(w > 0) || (masked && masks_[i].data()[p] == 0)) continue;
      const auto z = static_cast<float>(normalisation_.unit / static_cast<double>(w));
      if (!std::isfinite(z) || z <= 0) continue;
      out.depth.data()[p] = z;
      out.confidence.data()[p] = depth.confidence.data()[p];
    }
    return out;
  }

  void measure(MvsSummary& summary, const std::vector<FrameGeometry>& out) const {
    std::size_t measured = 0;
    std::size_t all = 0;
    for (const FrameGeometry& frame : out) {
      for (const float c : frame.confidence.pixels()) measured += c >= 0.5F ? 1 : 0;
      all += frame.confidence.size().pixels();
    }
    summary.measured_share = static_cast<double>(measured) / static_cast<double>(all);
  }

  std::span<const ImageRgb> frames_;
  std::span<const ValidityMask> masks_;
  const MvsOptions& options_;
  ThreadPool& pool_;
  Monitor& monitor_;
  Normalisation normalisation_;
  SparseScene scene_;
  Size size_;
  std::vector<std::size_t> keys_;                 ///< Frames that are matched, ascending; the first and last are.
  std::vector<std::vector<int>> neighbours_;      ///< Per key: frames.
  std::vector<DepthRange> ranges_;                ///< Per key.
  std::vector<View> views_;                       ///< Per frame.
  std::vector<MatchedDepth> matched_;             ///< Per key; empty where there was nothing to compare with.
  std::vector<std::vector<std::size_t>> judges_;  ///< Per key: keys whose depths its own is compared with.
  std::vector<RatedDepth> rated_;                 ///< Per key.
};

void check_inputs(std::span<const ImageRgb> frames, std::span<const Camera> cameras,
                  std::span<const ValidityMask> masks) {
  require(!frames.empty(), "multi-view stereo needs at least one frame");
  require(cameras.size() == frames.size(), "{} cameras for {} frames", cameras.size(), frames.size());
  require(masks.empty() || masks.size() == frames.size(), "{} masks for {} frames", masks.size(), frames.size());
  const Size size = frames.front().size();
  require(size.pixels() > 0, "frames are empty");
  for (std::size_t i = 0; i < frames.size(); ++i) {
    require(frames[i].size() == size, "frame {} is {}x{}, frame 0 {}x{}", i, frames[i].width(), frames[i].height(),
            size.width, size.height);
    require(cameras[i].size == size, "camera {} is for {}x{}, its frame is {}x{}", i, cameras[i].size.width,
            cameras[i].size.height, size.width, size.height);
    const Intrinsics& k = cameras[i].intrinsics;
    require(std::isfinite(k.fx) && std::isfinite(k.fy) && std::isfinite(k.cx) && std::isfinite(k.cy) && k.fx != 0 &&
                k.fy != 0,
            "camera {} has no usable focal length or centre", i);
    require(cameras[i].world_from_cam.translation.allFinite() && cameras[i].world_from_cam.rotation.allFinite(),
            "camera {} has a pose that is not finite", i);
    if (!masks.empty() && !masks[i].empty())
      require(masks[i].size() == size, "mask {} is {}x{}, its frame is {}x{}", i, masks[i].width(), masks[i].height(),
              size.width, size.height);
  }
}

}  // namespace
}  // namespace mvs

void MvsOptions::check() const {
  require(neighbours >= 1 && neighbours <= 16, "neighbours is {}, wanted 1 to 16", neighbours);
  require(planes >= 4 && planes <= 1024, "planes is {}, wanted 4 to 1024", planes);
  require(scale > 0 && scale <= 1, "scale is {}, wanted above 0 to 1", scale);
  require(key_stride >= 0, "key_stride is {}, wanted 0 (by the motion) or more", key_stride);
  require(consistency > 0 && consistency <= 0.5, "consistency is {}, wanted above 0 to 0.5", consistency);
}

std::string MvsSummary::brief() const {
  return fmt::format("{} frames matched, {:.0f}% of the pixels measured, {:.1f} s", matched_frames,
                     100 * measured_share, seconds);
}

MvsSummary multi_view_stereo(std::span<const ImageRgb> frames, std::span<const Camera> cameras,
                             std::span<const ScenePoint> points, std::span<const ValidityMask> static_pixels,
                             const MvsOptions& options, ThreadPool& pool, Monitor& monitor,
                             std::vector<FrameGeometry>& frames_out) {
  options.check();
  mvs::check_inputs(frames, cameras, static_pixels);
  const auto start = std::chrono::steady_clock::now();
  MvsSummary summary;
  frames_out.assign(frames.size(), {});
  mvs::Job(frames, cameras, points, static_pixels, options, pool, monitor).run(summary, frames_out);
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return summary;
}

}  // namespace uwv
