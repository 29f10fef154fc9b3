// SPDX-License-Identifier: Apache-2.0
// Scenes and comparisons for the tests of every renderer.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "support/naive_rasterizer.h"

namespace uwv::testing {

/// A grid with everything it points to, and where it is to be seen from.
struct Scene {
  std::string name;
  Camera source, target;
  DepthMap depth;
  SlopeMap slopes;
  ValidityMask keep;
  ImageRgbF colour;
  FootprintOptions footprint;
  bool use_slopes = true, use_keep = true;
  bool can_be_empty = false;

  PointGrid grid() const { return {source, &depth, use_slopes ? &slopes : nullptr, use_keep ? &keep : nullptr}; }
};

inline Camera test_camera(Size size, double fov_x, const Eigen::Vector3d& centre = Eigen::Vector3d::Zero(),
                          double yaw = 0, double pitch = 0) {
  Camera camera;
  camera.size = size;
  camera.intrinsics = Intrinsics::from_fov_x(fov_x, size);
  camera.world_from_cam.rotation =
      (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  camera.world_from_cam.translation = centre;
  return camera;
}

/// Depths from `depth_at(x, y, random)`, random slopes within +-`tilt`, nine points of ten kept, random colours.
inline Scene make_scene(std::string name, const Camera& source, const Camera& target, float tilt,
                        const std::function<float(int, int, float)>& depth_at) {
  Scene scene;
  scene.name = std::move(name);
  scene.source = source;
  scene.target = target;
  scene.depth = DepthMap(source.size);
  scene.slopes = SlopeMap(source.size);
  scene.keep = ValidityMask(source.size);
  scene.colour = ImageRgbF(source.size);
  std::mt19937 generator(7);
  std::uniform_real_distribution<float> uniform(0, 1);
  const auto random = [&] { return uniform(generator); };
  for (int y = 0; y < source.size.height; ++y)
    for (int x = 0; x < source.size.width; ++x) {
      scene.depth(x, y) = depth_at(x, y, random());
      scene.slopes(x, y) = {tilt * (2 * random() - 1), tilt * (2 * random() - 1)};
      scene.keep(x, y) = random() < 0.9F ? 1 : 0;
      scene.colour(x, y) = {random(), random(), 2 * random() - 1};
    }
  return scene;
}

/// A plane whose inverse depth is 1/z = (1 + gx*x + gy*y) / z0, with its exact slopes.
inline Scene make_plane(std::string name, const Camera& source, const Camera& target, float z0, float gx, float gy) {
  Scene scene = make_scene(std::move(name), source, target, 0, [](int, int, float) { return 1.0F; });
  for (int y = 0; y < source.size.height; ++y)
    for (int x = 0; x < source.size.width; ++x) {
      const float relative = 1 + gx * static_cast<float>(x) + gy * static_cast<float>(y);
      scene.depth(x, y) = relative > 0 ? z0 / relative : 0;
      scene.slopes(x, y) = {gx / relative, gy / relative};
    }
  scene.use_keep = false;
  return scene;
}

/// Small enough for every backend; each shows something another does not.
inline std::vector<Scene> all_scenes() {
  const Size size{96, 64};
  const Camera origin = test_camera(size, 1.0);
  std::vector<Scene> scenes;
  scenes.push_back(make_scene("random", origin, test_camera(size, 1.0, {0.7, -0.2, 0.4}, -0.2, 0.1), 0.05F,
                              [](int, int, float random) { return 2 + 3 * random; }));
  scenes.push_back(make_scene("identity", origin, origin, 0.05F, [](int, int, float random) { return 1 + random; }));
  scenes.push_back(
      make_scene("ties", origin, test_camera({48, 40}, 1.0, {0.3, 0, 0}), 0, [](int, int, float) { return 4.0F; }));
  scenes.push_back(make_plane("floor", origin, test_camera(size, 1.0, {0, -0.6, 0.8}, 0.3, -0.4), 8, 0, 0.06F));
  scenes.push_back(make_plane("wall", origin, test_camera(size, 0.9, {1.5, 0.1, 0.2}, -0.6, 0.05), 3, 0.004F, -0.002F));
  scenes.push_back(make_plane("magnified", origin, test_camera(size, 0.1, {0.05, 0, 2.2}), 3, 0.001F, 0.002F));
  scenes.back().footprint.max_footprint = 255;
  scenes.push_back(make_scene("fat points", origin, test_camera({33, 21}, 1.2, {0.4, 0.3, 0.1}), 0.3F,
                              [](int, int, float random) { return 1 + random; }));
  scenes.back().footprint.point_size = 3.5F;
  scenes.push_back(make_scene("wide points", origin, test_camera({41, 30}, 1.4, {-0.3, 0.2, -0.5}), 0.1F,
                              [](int, int, float random) { return 1 + random; }));
  scenes.back().footprint.min_footprint = 2.5F;
  scenes.push_back(make_scene("behind and on the camera plane", origin, test_camera(size, 1.0, {0.1, 0, 2.0}), 0.02F,
                              [](int x, int, float random) { return x % 3 == 0 ? 2.0F : 1 + 2 * random; }));
  scenes.push_back(make_scene("extreme depths", origin, test_camera(size, 1.0, {1e-6, 0, -1e-6}), 1.0F,
                              [](int x, int y, float random) {
                                const float far = (x + y) % 2 == 0 ? 1e9F : 5e11F;
                                return random < 0.2F ? 0 : random < 0.5F ? 1e-6F : far;
                              }));
  scenes.push_back(make_scene("170 degrees", test_camera(size, 170 * M_PI / 180),
                              test_camera({128, 72}, 170 * M_PI / 180, {0.5, 0, 0.3}, 1.0), 0.1F,
                              [](int, int, float random) { return 0.2F + 2 * random; }));
  scenes.push_back(make_scene("far away from everything", origin, test_camera(size, 1.0, {1e6, 0, 0}), 0.1F,
                              [](int, int, float) { return 5.0F; }));
  scenes.back().can_be_empty = true;
  scenes.push_back(make_scene("nothing valid", origin, origin, 0.1F, [](int, int, float) { return 0.0F; }));
  scenes.back().can_be_empty = true;
  scenes.push_back(make_scene("1x1", test_camera({1, 1}, 1.0), test_camera({1, 1}, 1.0, {0.01, 0, 0}), 0,
                              [](int, int, float) { return 1.0F; }));
  scenes.back().use_keep = false;
  scenes.push_back(make_scene("3x2", test_camera({3, 2}, 1.0), test_camera({2, 3}, 1.0, {0, 0, 0.5}), 0.1F,
                              [](int, int, float random) { return 1 + random; }));
  scenes.back().use_slopes = scenes.back().use_keep = false;
  return scenes;
}

/// Rounding at pixel borders may flip this share of the pixels; everything else is identical.
inline std::size_t allowed_flips(Size size) { return size.pixels() * 5 / 10000; }

/// Counts pixels for which `same(i)` does not hold, and names the first.
inline void expect_few_flips(Size size, const char* what, const std::function<bool(std::size_t)>& same,
                             const std::function<std::string(std::size_t)>& describe) {
  std::size_t flips = 0, first = 0;
  for (std::size_t i = 0; i < size.pixels(); ++i)
    if (!same(i) && flips++ == 0) first = i;
  const auto width = static_cast<std::size_t>(size.width);
  EXPECT_LE(flips, allowed_flips(size)) << what << " differs at " << flips << " of " << size.pixels()
                                        << " pixels; first at (" << first % width << ", " << first / width
                                        << "): " << describe(first);
}

inline bool close(float a, float b, float tolerance) {
  return std::abs(a - b) <= tolerance * std::max({1e-30F, std::abs(a), std::abs(b)});
}

inline void expect_same(const ZBuffer& wanted, const ZBuffer& got) {
  ASSERT_EQ(wanted.winner.size(), got.winner.size());
  ASSERT_EQ(wanted.depth.size(), got.depth.size());
  const std::uint32_t *wanted_winner = wanted.winner.data(), *got_winner = got.winner.data();
  const float *wanted_depth = wanted.depth.data(), *got_depth = got.depth.data();
  const Size size = wanted.winner.size();
  expect_few_flips(
      size, "winner", [&](std::size_t i) { return wanted_winner[i] == got_winner[i]; },
      [&](std::size_t i) { return fmt::format("wanted {:#x}, got {:#x}", wanted_winner[i], got_winner[i]); });
  expect_few_flips(
      size, "depth", [&](std::size_t i) { return close(wanted_depth[i], got_depth[i], 1e-6F); },
      [&](std::size_t i) { return fmt::format("wanted {}, got {}", wanted_depth[i], got_depth[i]); });
}

inline void expect_same(const ValidityMask& wanted, const ValidityMask& got) {
  ASSERT_EQ(wanted.size(), got.size());
  expect_few_flips(
      wanted.size(), "mask", [&](std::size_t i) { return wanted.data()[i] == got.data()[i]; },
      [&](std::size_t i) { return fmt::format("wanted {}, got {}", wanted.data()[i], got.data()[i]); });
}

/// Sums of floats depend on their order: 1e-4 of the value, or of the colours' range.
inline void expect_same(const SoftSplat& wanted, const SoftSplat& got) {
  ASSERT_EQ(wanted.depth.size(), got.depth.size());
  ASSERT_EQ(wanted.colour.size(), got.colour.size());
  expect_same(wanted.valid, got.valid);
  expect_few_flips(
      wanted.depth.size(), "soft depth",
      [&](std::size_t i) { return close(wanted.depth.data()[i], got.depth.data()[i], 1e-4F); },
      [&](std::size_t i) { return fmt::format("wanted {}, got {}", wanted.depth.data()[i], got.depth.data()[i]); });
  const RgbF *a = wanted.colour.data(), *b = got.colour.data();
  expect_few_flips(
      wanted.colour.size(), "soft colour",
      [&](std::size_t i) {
        return std::max({std::abs(a[i].r - b[i].r), std::abs(a[i].g - b[i].g), std::abs(a[i].b - b[i].b)}) <= 1e-4F;
      },
      [&](std::size_t i) {
        return fmt::format("wanted {} {} {}, got {} {} {}", a[i].r, a[i].g, a[i].b, b[i].r, b[i].g, b[i].b);
      });
}

/// fill() must put into empty pixels, and only there, what zbuffer() of the added points has.
inline void expect_fills_empty_pixels(Rasterizer& rasterizer, const Scene& scene) {
  const ValidityMask sparse = [&] {
    ValidityMask mask = scene.use_keep ? scene.keep : ValidityMask(scene.source.size, 1);
    for (std::size_t i = 0; i < mask.size().pixels(); ++i) mask.data()[i] &= i % 3 == 0;
    return mask;
  }();
  PointGrid grid = scene.grid();
  grid.keep = &sparse;
  FootprintOptions wide = scene.footprint;
  wide.min_footprint = std::min(3.0F, wide.max_footprint);
  ZBuffer wanted, added, got;
  rasterizer.zbuffer(grid, scene.target, scene.footprint, wanted);
  rasterizer.zbuffer(scene.grid(), scene.target, wide, added);
  got = wanted;
  for (std::size_t i = 0; i < wanted.winner.size().pixels(); ++i)
    if (wanted.winner.data()[i] == PointCode::none) {
      wanted.winner.data()[i] = added.winner.data()[i];
      wanted.depth.data()[i] = added.depth.data()[i];
    }
  rasterizer.fill(scene.grid(), scene.target, wide, got);
  expect_same(wanted, got);
}

/// Parts of a grid's points: all, none, one, a half, and most of them at random.
inline std::vector<ValidityMask> parts_of(const Scene& scene) {
  const Size size = scene.source.size;
  const ValidityMask all = scene.use_keep ? scene.keep : ValidityMask(size, 1);
  std::vector<ValidityMask> parts{all, ValidityMask(size), ValidityMask(size), all, all};
  parts[2](size.width / 2, size.height / 2) = all(size.width / 2, size.height / 2);
  std::mt19937 generator(3);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      if (x < size.width / 2) parts[3](x, y) = 0;
      if (generator() % 20 == 0) parts[4](x, y) = 0;
    }
  return parts;
}

/// narrow() must give what zbuffer() gives, and count the pixels whose winner went.
inline void expect_narrows_to_parts(Rasterizer& rasterizer, const Scene& scene) {
  ZBuffer whole;
  rasterizer.zbuffer(scene.grid(), scene.target, scene.footprint, whole);
  for (const ValidityMask& part : parts_of(scene)) {
    PointGrid grid = scene.grid();
    grid.keep = &part;
    ZBuffer wanted, got = whole;
    rasterizer.zbuffer(grid, scene.target, scene.footprint, wanted);
    const std::size_t changed = rasterizer.narrow(grid, scene.target, scene.footprint, got);
    expect_same(wanted, got);
    std::size_t lost = 0;
    for (std::size_t i = 0; i < whole.winner.size().pixels(); ++i)
      lost += whole.winner.data()[i] != wanted.winner.data()[i];
    EXPECT_EQ(changed, lost);
  }
}

}  // namespace uwv::testing
