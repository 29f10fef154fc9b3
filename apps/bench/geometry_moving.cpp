// SPDX-License-Identifier: Apache-2.0
// What moves by itself, and what is behind it, against a scene of which everything is known.
#include <cmath>
#include <ctime>
#include <numbers>

#include "bench/benchmarks.h"
#include "uwv/eval/stock_scenes.h"
#include "uwv/geometry/background_from_views.h"
#include "uwv/geometry/moving_objects.h"

namespace uwv::bench {
namespace {

constexpr int ball = 0;  // index in the stock scene

/// The ball scene from an orbiting camera, with and without its ball.
struct Clip {
  std::vector<ImageRgb> frames, empty_frames;
  std::vector<Camera> cameras;
  std::vector<FrameGeometry> truth, behind;  ///< With the ball, and of the scene without it.
  std::vector<ForegroundMask> ball;
};

Clip film(Size size, int count, double degrees, double seconds, ThreadPool& pool) {
  const StockScene with = moving_ball({.size = size});
  StockScene without = with;
  without.scene.objects.erase(without.scene.objects.begin() + bench::ball);
  Clip clip;
  for (int i = 0; i < count; ++i) {
    const double share = count > 1 ? static_cast<double>(i) / (count - 1) : 0.0;
    const double angle = (share - 0.5) * degrees * std::numbers::pi / 180;
    const Camera camera = orbit_camera(with.source, with.subject_in_world, angle);
    SyntheticFrame seen = render(with.scene, camera, share * seconds, pool, 2);
    SyntheticFrame empty = render(without.scene, camera, share * seconds, pool, 2);
    ForegroundMask& mask = clip.ball.emplace_back(size);
    for (std::size_t p = 0; p < mask.pixels().size(); ++p) mask.pixels()[p] = seen.object.pixels()[p] == bench::ball;
    clip.cameras.push_back(camera);
    clip.frames.push_back(std::move(seen.colour));
    clip.empty_frames.push_back(std::move(empty.colour));
    clip.truth.push_back({std::move(seen.depth), ConfidenceMap(size, 1.0F)});
    clip.behind.push_back({std::move(empty.depth), ConfidenceMap(size, 1.0F)});
  }
  return clip;
}

/// Seconds of processor time, all threads together, which other programs on the machine disturb least.
template <class Work>
double processor_seconds(const Work& work) {
  const std::clock_t begin = std::clock();
  work();
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

void add_pixels(Table& table, const std::string& changed, const Clip& clip, bool depth_known,
                const MovingOptions& options, ThreadPool& pool) {
  Monitor monitor;
  MovingPixels found;
  std::span<const FrameGeometry> coarse;
  if (depth_known) coarse = clip.truth;
  const double seconds =
      processor_seconds([&] { found = find_moving_pixels(clip.frames, clip.cameras, coarse, options, pool, monitor); });
  double both = 0, either = 0, wrong = 0, still = 0;
  for (std::size_t i = 0; i < clip.ball.size(); ++i)
    for (std::size_t p = 0; p < clip.ball[i].pixels().size(); ++p) {
      const bool says = found.static_pixels[i].pixels()[p] == 0, moves = clip.ball[i].pixels()[p] != 0;
      both += says && moves ? 1 : 0;
      either += says || moves ? 1 : 0;
      wrong += says && !moves ? 1 : 0;
      still += moves ? 0 : 1;
    }
  table.add({changed, depth_known ? "yes" : "no", both / either, 100 * wrong / still,
             seconds / static_cast<double>(clip.frames.size())});
}

void add_background(Table& table, const std::string& changed, const Clip& clip, const ViewsOptions& options,
                    ThreadPool& pool) {
  Monitor monitor;
  std::vector<FrameGeometry> known = clip.truth;
  for (std::size_t i = 0; i < known.size(); ++i)
    for (std::size_t p = 0; p < known[i].depth.pixels().size(); ++p)
      if (clip.ball[i].pixels()[p] != 0) known[i].depth.pixels()[p] = 0;
  ViewsBackground got;
  const double seconds = processor_seconds(
      [&] { got = background_from_views(clip.frames, clip.cameras, known, clip.ball, options, pool, monitor); });
  double squared = 0, relative = 0, hidden = 0, invented = 0;
  for (std::size_t i = 0; i < got.frames.size(); ++i)
    for (std::size_t p = 0; p < got.frames[i].pixels().size(); ++p) {
      const auto origin = static_cast<BackgroundOrigin>(got.origin[i].pixels()[p]);
      if (origin == BackgroundOrigin::own) continue;
      const Rgb8 a = got.frames[i].pixels()[p], b = clip.empty_frames[i].pixels()[p];
      squared += (std::pow(a.r - b.r, 2) + std::pow(a.g - b.g, 2) + std::pow(a.b - b.b, 2)) / 3;
      const double truth = clip.behind[i].depth.pixels()[p];
      relative += std::abs(got.depth[i].pixels()[p] - truth) / truth;
      invented += origin == BackgroundOrigin::invented ? 1 : 0;
      hidden += 1;
    }
  table.add({changed, 100 * (1 - invented / hidden), 10 * std::log10(255.0 * 255.0 * hidden / squared),
             relative / hidden, seconds / static_cast<double>(clip.frames.size())});
}

}  // namespace

std::vector<Table> moving(const BenchOptions& options) {
  options.check();
  ThreadPool pool(options.threads);
  const std::string size = fmt::format("{}x{}", options.size.width, options.size.height);
  const Clip quick = film(options.size, 7, 6, 0.24, pool);
  Table pixels("moving pixels, 7 frames of " + size, {"changed", "depth known", "overlap", "false_%", "cpu_s/frame"});
  add_pixels(pixels, "nothing", quick, false, {}, pool);
  add_pixels(pixels, "nothing", quick, true, {}, pool);
  add_pixels(pixels, "distances 1", quick, false, {.distances = 1}, pool);
  add_pixels(pixels, "distances 2", quick, false, {.distances = 2}, pool);
  add_pixels(pixels, "flow_height 120", quick, false, {.flow_height = 120}, pool);
  add_pixels(pixels, "flow_height 160", quick, false, {.flow_height = 160}, pool);
  add_pixels(pixels, "flow_height 360", quick, false, {.flow_height = 360}, pool);

  const Clip passing = film(options.size, 21, 8, 1.0, pool);
  Table background("background of 21 frames of " + size, {"changed", "seen_%", "psnr", "abs_rel", "cpu_s/frame"});
  add_background(background, "nothing", passing, {}, pool);
  for (const int views : {2, 4, 8, 20})
    add_background(background, fmt::format("views {}", views), passing, {.views = views}, pool);
  add_background(background, "reach_frames 5", passing, {.reach_frames = 5}, pool);
  add_background(background, "doubt 0", passing, {.doubt = 0}, pool);
  add_background(background, "depth_tolerance 0.01", passing, {.depth_tolerance = 0.01}, pool);
  return {pixels, background};
}

}  // namespace uwv::bench
