// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/wrong_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "observer.h"
#include "uwv/core/depth.h"

namespace uwv {
namespace {

using Eigen::Vector3d;

// How well the sources know a surface point; a higher value wins between sources.
enum class Knowledge : std::uint8_t { unknown, barely, known };

struct Source {
  Observer observer;
  Image<std::uint8_t> silhouettes;  // the one-pixel band around changes of object
  Vector3d target_to_source;
};

enum class Side { front, back, unclear };

// What is to be told about one surface point on a target ray.
struct PointFacts {
  Knowledge knowledge = Knowledge::unknown;
  Side side = Side::unclear;  // of the surface as the target sees it, the front being what a source saw
};

class Judge {
 public:
  Judge(const Scene& scene, double time, const Camera& target, std::span<const Camera> sources, ThreadPool& pool,
        const WrongSurfaceOptions& options)
      : options_(options), target_(scene, target, time), hits_(first_hits(target_, pool)) {
    for (const Camera& camera : sources) {
      Source source{
          Observer(scene, camera, time), {}, camera.world_from_cam.translation - target.world_from_cam.translation};
      source.silhouettes = border_band(first_hits(source.observer, pool).object);
      sources_.push_back(std::move(source));
    }
  }

  const FirstHits& hits() const { return hits_; }

  // Counts a shown pixel if it is wrong.
  void shown(int x, int y, double depth, std::vector<Crossing>& scratch, WrongSurface& counts) const;
  // Facts of the true surface at a pixel's centre; nothing when there is none.
  std::optional<PointFacts> true_surface(int x, int y) const {
    if (hits_.object(x, y) < 0) return std::nullopt;
    return facts(direction(x, y), {hits_.object(x, y), hits_.depth(x, y)});
  }

 private:
  struct Range {
    double nearest = std::numeric_limits<double>::infinity();
    double farthest = 0;
    bool one_object = true;
  };

  Vector3d direction(int x, int y) const { return pixel_direction(target_.camera(), x + 0.5, y + 0.5); }
  Range around(int x, int y) const;
  PointFacts facts(const Vector3d& direction, const Crossing& crossing) const;
  void behind(const Vector3d& direction, double depth, std::vector<Crossing>& scratch, WrongSurface& counts) const;

  WrongSurfaceOptions options_;
  Observer target_;
  FirstHits hits_;
  std::vector<Source> sources_;
};

Judge::Range Judge::around(int x, int y) const {
  Range range;
  for (int v = y - 1; v <= y + 1; ++v) {
    for (int u = x - 1; u <= x + 1; ++u) {
      if (!hits_.depth.contains(u, v)) continue;
      range.one_object &= hits_.object(u, v) == hits_.object(x, y);
      const double depth = hits_.object(u, v) < 0 ? std::numeric_limits<double>::infinity() : hits_.depth(u, v);
      range.nearest = std::min(range.nearest, depth);
      range.farthest = std::max(range.farthest, depth);
    }
  }
  return range;
}

PointFacts Judge::facts(const Vector3d& direction, const Crossing& crossing) const {
  PointFacts facts;
  const Vector3d from_target = crossing.distance * direction;
  const Vector3d normal = target_.view().resolve(direction, crossing).normal_in_world;
  const double target_cosine = normal.dot(from_target.normalized());
  for (const Source& source : sources_) {
    const Vector3d from_source = from_target - source.target_to_source;
    int x = 0, y = 0;
    if (!source.observer.pixel_of(from_source, x, y) || !source.observer.unobstructed(from_source)) continue;
    facts.knowledge = std::max(facts.knowledge, source.silhouettes(x, y) != 0 ? Knowledge::barely : Knowledge::known);
    const double source_cosine = normal.dot(from_source.normalized());
    if (std::min(std::abs(target_cosine), std::abs(source_cosine)) < options_.grazing) continue;
    // Any source that saw the target's side makes it a front.
    const bool same = target_cosine * source_cosine > 0;
    facts.side = same || facts.side == Side::front ? Side::front : Side::back;
  }
  return facts;
}

void Judge::shown(int x, int y, double depth, std::vector<Crossing>& scratch, WrongSurface& counts) const {
  const Range range = around(x, y);
  if (depth < range.nearest * (1 - options_.depth_tolerance)) {
    ++counts.floating;
  } else if (depth > range.farthest * (1 + options_.depth_tolerance)) {
    behind(direction(x, y), depth, scratch, counts);
  } else if (range.one_object) {
    // The right surface, but perhaps one without thickness whose other side is what the source saw.
    const std::optional<PointFacts> facts = true_surface(x, y);
    if (facts && facts->side == Side::back) ++counts.back_faces;
  }
}

void Judge::behind(const Vector3d& direction, double depth, std::vector<Crossing>& scratch,
                   WrongSurface& counts) const {
  target_.view().crossings(direction, depth * (1 + options_.depth_tolerance), scratch);
  Knowledge in_the_way = Knowledge::unknown;
  std::optional<Crossing> shown;
  for (const Crossing& crossing : scratch) {
    if (crossing.distance < depth * (1 - options_.depth_tolerance)) {
      in_the_way = std::max(in_the_way, facts(direction, crossing).knowledge);
    } else if (!shown || std::abs(crossing.distance - depth) < std::abs(shown->distance - depth)) {
      shown = crossing;
    }
  }
  if (shown && facts(direction, *shown).side == Side::back) {
    ++counts.back_faces;
    return;
  }
  switch (in_the_way) {
    case Knowledge::known: ++counts.through_known; break;
    case Knowledge::barely: ++counts.through_border; break;
    case Knowledge::unknown: ++counts.through_unknown; break;
  }
}

WrongSurface& operator+=(WrongSurface& a, const WrongSurface& b) {
  a.valid += b.valid;
  a.through_known += b.through_known;
  a.through_unknown += b.through_unknown;
  a.through_border += b.through_border;
  a.back_faces += b.back_faces;
  a.floating += b.floating;
  return a;
}

// Counts row by row, so that the sum does not depend on the threads.
WrongSurface judge_shown(const Judge& judge, const Image<std::uint8_t>& shown, const DepthMap& depth,
                         ThreadPool& pool) {
  std::vector<WrongSurface> rows(static_cast<std::size_t>(depth.height()));
  pool.for_ranges(0, depth.height(), 4, [&](int from, int to) {
    std::vector<Crossing> scratch;
    for (int y = from; y < to; ++y) {
      WrongSurface& row = rows[static_cast<std::size_t>(y)];
      for (int x = 0; x < depth.width(); ++x) {
        if (shown(x, y) == 0) continue;
        ++row.valid;
        judge.shown(x, y, static_cast<double>(depth(x, y)), scratch, row);
      }
    }
  });
  WrongSurface sum;
  for (const WrongSurface& row : rows) sum += row;
  return sum;
}

void count_holes(const Judge& judge, const Image<std::uint8_t>& shown, ThreadPool& pool, WrongSurface& counts) {
  Image<std::uint8_t> known(shown.size());
  pool.for_ranges(0, shown.height(), 4, [&](int from, int to) {
    for (int y = from; y < to; ++y) {
      for (int x = 0; x < shown.width(); ++x) {
        const std::optional<PointFacts> facts = judge.true_surface(x, y);
        known(x, y) = facts && facts->knowledge == Knowledge::known && facts->side == Side::front ? 1 : 0;
      }
    }
  });
  const Image<std::uint8_t> changes_of_knowledge = border_band(known);
  const Image<std::uint8_t> changes_of_object = border_band(judge.hits().object);
  for (std::size_t i = 0; i < known.pixels().size(); ++i) {
    if (known.pixels()[i] == 0 || changes_of_knowledge.pixels()[i] != 0 || changes_of_object.pixels()[i] != 0) continue;
    ++counts.known;
    if (shown.pixels()[i] == 0) ++counts.holes;
  }
}

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

void WrongSurfaceOptions::check() const {
  require(depth_tolerance > 0 && depth_tolerance < 1, "depth_tolerance must lie in (0, 1), not {}", depth_tolerance);
  require(grazing >= 0 && grazing < 1, "grazing must lie in [0, 1), not {}", grazing);
}

double WrongSurface::wrong_share() const { return share(through_known + back_faces, valid); }

double WrongSurface::hole_share() const { return share(holes, known); }

WrongSurface wrong_surface(const Scene& scene, double time, const Camera& target, std::span<const Camera> sources,
                           const DepthMap& depth, const ValidityMask& valid, ThreadPool& pool,
                           const WrongSurfaceOptions& options) {
  options.check();
  require(!sources.empty(), "a rendering is made from at least one source");
  require(depth.size() == target.size && valid.size() == target.size,
          "the target's picture is {}x{}, but depth is {}x{} and valid {}x{}", target.size.width, target.size.height,
          depth.width(), depth.height(), valid.width(), valid.height());
  const Judge judge(scene, time, target, sources, pool, options);
  Image<std::uint8_t> shown(target.size);
  for (std::size_t i = 0; i < shown.pixels().size(); ++i)
    shown.pixels()[i] = valid.pixels()[i] != 0 && is_valid_depth(depth.pixels()[i]) ? 1 : 0;
  WrongSurface counts = judge_shown(judge, shown, depth, pool);
  count_holes(judge, shown, pool, counts);
  return counts;
}

}  // namespace uwv
