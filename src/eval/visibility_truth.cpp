// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/visibility_truth.h"

#include "observer.h"

namespace uwv {
namespace {

// Both cameras of one question, and where they stand relative to each other.
struct Pair {
  Observer source, target;
  Eigen::Vector3d target_to_source;  // world axes, taken as one difference so that far scenes stay exact

  bool seen_by_source(const Eigen::Vector3d& from_target) const {
    const Eigen::Vector3d from_source = from_target - target_to_source;
    int x = 0, y = 0;
    return source.pixel_of(from_source, x, y) && source.unobstructed(from_source);
  }
};

bool visible(const Pair& pair, const Eigen::Vector3d& from_source, std::vector<Crossing>& scratch) {
  const Eigen::Vector3d from_target = pair.target_to_source + from_source;
  int x = 0, y = 0;
  if (!pair.target.pixel_of(from_target, x, y)) return false;
  pair.target.view().crossings(from_target, 1 - end_of_ray, scratch);
  for (const Crossing& crossing : scratch)
    if (pair.seen_by_source(crossing.distance * from_target)) return false;
  return true;
}

ExcludedMask excluded_pixels(const ValidityMask& visible, const FirstHits& hits) {
  ExcludedMask excluded(border_band(visible));
  const Image<std::uint8_t> silhouettes = border_band(hits.object);
  for (std::size_t i = 0; i < excluded.pixels().size(); ++i)
    if (silhouettes.pixels()[i] != 0 || hits.object.pixels()[i] < 0) excluded.pixels()[i] = 1;
  return excluded;
}

double share(std::size_t part, std::size_t rest) {
  return part + rest == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(part + rest);
}

}  // namespace

VisibilityTruth visibility_truth(const Scene& scene, const Camera& source, const Camera& target, double time,
                                 ThreadPool& pool) {
  const Pair pair{Observer(scene, source, time), Observer(scene, target, time),
                  source.world_from_cam.translation - target.world_from_cam.translation};
  const FirstHits hits = first_hits(pair.source, pool);
  VisibilityTruth truth{ValidityMask(source.size), {}};
  pool.for_ranges(0, source.size.height, 4, [&](int from, int to) {
    std::vector<Crossing> scratch;
    for (int y = from; y < to; ++y) {
      for (int x = 0; x < source.size.width; ++x) {
        if (hits.object(x, y) < 0) continue;
        const Eigen::Vector3d from_source = hits.depth(x, y) * pixel_direction(source, x + 0.5, y + 0.5);
        truth.visible(x, y) = visible(pair, from_source, scratch) ? 1 : 0;
      }
    }
  });
  truth.excluded = excluded_pixels(truth.visible, hits);
  return truth;
}

void accumulate(VisibilityTruth& path, const VisibilityTruth& next) {
  require(path.visible.size() == next.visible.size(), "cannot accumulate a truth of {}x{} pixels into one of {}x{}",
          next.visible.width(), next.visible.height(), path.visible.width(), path.visible.height());
  for (std::size_t i = 0; i < path.visible.pixels().size(); ++i) {
    std::uint8_t& visible = path.visible.pixels()[i];
    std::uint8_t& excluded = path.excluded.pixels()[i];
    const bool surely_hidden =
        (visible == 0 && excluded == 0) || (next.visible.pixels()[i] == 0 && next.excluded.pixels()[i] == 0);
    excluded = !surely_hidden && (excluded != 0 || next.excluded.pixels()[i] != 0) ? 1 : 0;
    visible = visible != 0 && next.visible.pixels()[i] != 0 ? 1 : 0;
  }
}

double PrecisionRecall::precision() const { return share(tp, fp); }

double PrecisionRecall::recall() const { return share(tp, fn); }

double PrecisionRecall::f1() const {
  const double sum = precision() + recall();
  return sum == 0 ? 0.0 : 2 * precision() * recall() / sum;
}

PrecisionRecall compare(const ValidityMask& mask, const ValidityMask& truth, const ExcludedMask& excluded) {
  require(mask.size() == truth.size() && mask.size() == excluded.size(),
          "cannot compare a mask of {}x{} pixels with a truth of {}x{} and excluded pixels of {}x{}", mask.width(),
          mask.height(), truth.width(), truth.height(), excluded.width(), excluded.height());
  PrecisionRecall counts;
  for (std::size_t i = 0; i < mask.pixels().size(); ++i) {
    if (excluded.pixels()[i] != 0) continue;
    const bool claimed = mask.pixels()[i] != 0;
    const bool is_true = truth.pixels()[i] != 0;
    ++(claimed ? (is_true ? counts.tp : counts.fp) : (is_true ? counts.fn : counts.tn));
  }
  return counts;
}

PrecisionRecall compare(const ValidityMask& mask, const VisibilityTruth& truth) {
  return compare(mask, truth.visible, truth.excluded);
}

}  // namespace uwv
