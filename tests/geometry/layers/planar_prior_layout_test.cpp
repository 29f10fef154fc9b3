// SPDX-License-Identifier: Apache-2.0
// The planar prior's reading of a picture, against scenes whose depth is known.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "uwv/geometry/planar_prior.h"

namespace uwv {
namespace {

constexpr double degree = std::numbers::pi / 180;

struct Truth {
  ImageRgb picture;
  DepthMap depth;  ///< 0 = sky.
  Intrinsics intrinsics;
};

/// Repeatable texture of +-`amount` about a colour.
Rgb8 textured(Rgb8 c, int x, int y, int amount) {
  const int n = static_cast<int>((static_cast<unsigned>(x) * 2654435761U ^ static_cast<unsigned>(y) * 40503U) >> 7) %
                    (2 * amount + 1) -
                amount;
  const auto shift = [n](int v) { return static_cast<std::uint8_t>(std::clamp(v + n, 0, 255)); };
  return {shift(c.r), shift(c.g), shift(c.b)};
}

/// A street: asphalt 1.6 below a level camera, house fronts 4 to either side and 5 high, a white wall across it 16
/// away and 2 high, sky above; a red box, 2 wide and 1.5 high, on the asphalt 7.5 away.
Truth street(Size size) {
  Truth out{ImageRgb(size), DepthMap(size), Intrinsics::from_fov_x(60 * degree, size)};
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const double right = (x + 0.5 - out.intrinsics.cx) / out.intrinsics.fx;
      const double down = (y + 0.5 - out.intrinsics.cy) / out.intrinsics.fy;
      double z = 1e9;
      Rgb8 colour{130, 180, 240};
      const auto hit = [&](double at, bool inside, Rgb8 c, int amount) {
        if (!(at > 0) || at >= z || !inside) return;
        z = at;
        colour = textured(c, x, y, amount);
      };
      if (down > 0) hit(1.6 / down, true, {70, 70, 78}, 5);
      const double side = 4 / std::fabs(right);
      hit(side, -down * side < 5, {150, 90, 60}, 25);
      hit(16, -down * 16 < 2, {190, 180, 160}, 8);
      const double at_box = right * 7.5 - 0.5;
      hit(7.5, std::fabs(at_box) < 1 && down * 7.5 > 0.1 && down * 7.5 < 1.6, {190, 30, 30}, 8);
      out.picture(x, y) = colour;
      out.depth(x, y) = z < 1e8 ? static_cast<float>(z) : 0;
    }
  return out;
}

PlanarPriorResult prior_of(const ImageRgb& picture, const PlanarPriorOptions& options = {}, double fov = 60 * degree,
                           int threads = 2) {
  ThreadPool pool(threads);
  Monitor monitor;
  const std::vector<ImageRgb> frames{picture};
  return planar_prior(frames, {}, Intrinsics::from_fov_x(fov, picture.size()), options, pool, monitor);
}

/// Mean of |z / truth - 1| where the truth is known, after one scale (the median of truth / z).
double abs_rel(const DepthMap& depth, const DepthMap& truth) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < truth.pixels().size(); ++i)
    if (truth.data()[i] > 0) ratios.push_back(static_cast<double>(depth.data()[i]) / truth.data()[i]);
  std::nth_element(ratios.begin(), ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2), ratios.end());
  const double middle = ratios[ratios.size() / 2];
  double sum = 0;
  for (double r : ratios) sum += std::fabs(r / middle - 1);
  return sum / static_cast<double>(ratios.size());
}

TEST(PlanarPriorLayout, StandsHousesAndBoxOnTheStreet) {
  const Truth truth = street({416, 240});
  PlanarPriorOptions level;
  level.find_contour = false;
  const PlanarPriorResult before = prior_of(truth.picture, level), after = prior_of(truth.picture);
  ASSERT_FALSE(after.contour.empty());
  EXPECT_TRUE(before.contour.empty());
  const double error_before = abs_rel(before.geometry.frames[0].depth, truth.depth);
  const double error_after = abs_rel(after.geometry.frames[0].depth, truth.depth);
  RecordProperty("abs_rel_level", fmt::format("{:.3f}", error_before));
  RecordProperty("abs_rel_contour", fmt::format("{:.3f}", error_after));
  EXPECT_GT(error_before, 0.2);
  EXPECT_LT(error_after, 0.08);
  // The box: middle of its front, a little above its foot.
  const int x = static_cast<int>(truth.intrinsics.cx + truth.intrinsics.fx * 0.5 / 7.5);
  const int y = static_cast<int>(truth.intrinsics.cy + truth.intrinsics.fy * 0.4 / 7.5);
  ASSERT_NEAR(truth.depth(x, y), 7.5, 1e-6);
  EXPECT_NEAR(after.geometry.frames[0].depth(x, y), 7.5, 0.6) << "upright, where it stands";
  EXPECT_TRUE(after.sky.believed);
  EXPECT_GT(after.geometry.frames[0].depth(208, 5), 60) << "sky";
}

TEST(PlanarPriorLayout, KeepsTheContourItIsGiven) {
  const Truth truth = street({416, 240});
  const PlanarPriorResult found = prior_of(truth.picture);
  ASSERT_FALSE(found.contour.empty());
  PlanarPriorOptions options;
  options.horizon_row = found.horizon_row;
  options.backdrop_row = found.backdrop_row;
  options.contour = found.contour;
  const PlanarPriorResult again = prior_of(truth.picture, options, 60 * degree, 1);
  for (std::size_t i = 0; i < truth.depth.pixels().size(); ++i)
    ASSERT_EQ(found.geometry.frames[0].depth.data()[i], again.geometry.frames[0].depth.data()[i]) << i;
  options.contour.pop_back();
  EXPECT_THROW(prior_of(truth.picture, options), std::invalid_argument);
}

TEST(PlanarPriorLayout, SeesNoContourInOneColourOrNoise) {
  for (const int amount : {0, 60}) {
    ImageRgb picture(208, 120);
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 208; ++x) picture(x, y) = textured({120, 110, 100}, x, y, amount);
    EXPECT_TRUE(prior_of(picture).contour.empty()) << amount;
  }
}

TEST(PlanarPriorLayout, BluishWallIsNoSky) {
  const Size size{320, 180};
  ImageRgb room(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      room(x, y) = y < 110 ? Rgb8{185, 195, 212} : textured({170, 160, 150}, x, y, 9);
  const PlanarPriorResult result = prior_of(room);
  EXPECT_GT(result.sky.share, 0.5) << "it has the looks of one";
  EXPECT_FALSE(result.sky.believed);
  EXPECT_EQ(result.sky_share, 0);
}

TEST(PlanarPriorLayout, CornerOfSkyIsSky) {
  const Size size{320, 180};
  ImageRgb picture(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      picture(x, y) = x > 250 && y < 50 ? Rgb8{214, 222, 250} : textured({70, 90, 40}, x, y, 25);
  const PlanarPriorResult result = prior_of(picture);
  EXPECT_TRUE(result.sky.believed);
  EXPECT_NEAR(result.sky_share, 69.0 * 50 / static_cast<double>(size.pixels()), 0.01);
}

TEST(PlanarPriorLayout, GroundIsNeverSteeperThanRenderersKeep) {
  const Size size{160, 90};
  for (const double fov : {10 * degree, 60 * degree, 100 * degree, 150 * degree}) {
    PlanarPriorOptions options;
    options.horizon_row = 40;
    options.backdrop_row = 40.5;
    const PlanarPriorResult result = prior_of(ImageRgb(size, Rgb8{90, 80, 70}), options, fov);
    const Intrinsics k = Intrinsics::from_fov_x(fov, size);
    const FrameGeometry& frame = result.geometry.frames[0];
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x) {
        ASSERT_TRUE(std::isfinite(frame.depth(x, y)) && frame.depth(x, y) > 0);
        if (frame.confidence(x, y) != 0.3F) continue;
        const Eigen::Vector3d ray((x + 0.5 - k.cx) / k.fx, (y + 0.5 - k.cy) / k.fy, 1);
        const Eigen::Vector3d down(0, std::cos(result.pitch), std::sin(result.pitch));
        const double tilt = std::acos(ray.normalized().dot(down)) / degree;
        ASSERT_LT(tilt, 86) << "field of view " << fov / degree << ", pixel " << x << ", " << y;
      }
  }
}

TEST(PlanarPriorLayout, IsFiniteForAllSizesAndLenses) {
  for (const Size size : {Size{1, 1}, Size{33, 32}, Size{400, 33}, Size{33, 400}})
    for (const double fov : {10.0, 60.0, 150.0}) {
      ImageRgb picture(size);
      for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x)
          picture(x, y) = 2 * y < size.height + x % 9 ? Rgb8{200, 40, 40} : Rgb8{40, 40, 60};
      const PlanarPriorResult result = prior_of(picture, {}, fov * degree);
      for (float z : result.geometry.frames[0].depth.pixels()) ASSERT_TRUE(std::isfinite(z) && z > 0);
    }
}

}  // namespace
}  // namespace uwv
