// SPDX-License-Identifier: Apache-2.0
// The steps of multi-view stereo one by one, on inputs small enough to know the answer.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/mvs/carry.h"
#include "geometry/mvs/completion.h"
#include "geometry/mvs/consistency.h"
#include "geometry/mvs/edge_snapping.h"
#include "geometry/mvs/view_selection.h"

namespace uwv::mvs {
namespace {

constexpr Size size{48, 32};

Camera camera_at(double x) {
  Camera camera;
  camera.size = size;
  camera.intrinsics = Intrinsics::from_fov_x(1.0, size);
  camera.world_from_cam.translation.x() = x;
  return camera;
}

View even_view(double x = 0) {
  View view;
  view.camera = camera_at(x);
  view.grey = Image<float>(size);
  view.colour = ImageRgb(size, Rgb8{80, 80, 80});
  return view;
}

RatedDepth flat_depth(float w) { return {InverseDepthMap(size, w), Image<float>(size, 0.9F)}; }

/// Cameras in a row, `step` apart, before a wall of points at depth 1.
SparseScene row_of_cameras(int count, double step) {
  SparseScene scene;
  for (int i = 0; i < count; ++i) scene.cameras.push_back(camera_at(i * step));
  for (int i = -20; i <= 20; ++i)
    for (int j = -3; j <= 3; ++j) scene.points.emplace_back(0.05 * i, 0.1 * j, 1.0);
  return scene;
}

TEST(ChooseNeighbours, PrefersAFewDegreesToTheNextFrameAndToTheFarthest) {
  const SparseScene scene = row_of_cameras(41, 0.5 * std::numbers::pi / 180);
  for (const int chosen : choose_neighbours(scene, 20, 4)) {
    EXPECT_GE(std::abs(chosen - 20), 4) << chosen;
    EXPECT_LE(std::abs(chosen - 20), 20) << chosen;
  }
}

TEST(ChooseNeighbours, TakesBothSides) {
  const SparseScene scene = row_of_cameras(41, 0.5 * std::numbers::pi / 180);
  const std::vector<int> chosen = choose_neighbours(scene, 20, 4);
  ASSERT_EQ(chosen.size(), 4U);
  EXPECT_LT(*std::min_element(chosen.begin(), chosen.end()), 20);
  EXPECT_GT(*std::max_element(chosen.begin(), chosen.end()), 20);
}

TEST(ChooseNeighbours, AreNoneWithoutParallax) {
  EXPECT_TRUE(choose_neighbours(row_of_cameras(5, 0), 2, 4).empty());
  EXPECT_TRUE(choose_neighbours(row_of_cameras(1, 0), 0, 4).empty());
}

TEST(DepthRangeOfPoints, CoversThemAndNoOutlier) {
  SparseScene scene = row_of_cameras(2, 0.1);
  for (int i = 0; i < 3; ++i) scene.points.emplace_back(0, 0, 1e-300);
  const DepthRange range = depth_range(scene, 0);
  EXPECT_LT(range.farthest, 1.0F);
  EXPECT_GT(range.nearest, 1.0F);
  EXPECT_LT(range.nearest, 2.0F);
}

TEST(DepthRangeOfPoints, IsFiniteWhateverThePoints) {
  for (const double z : {1e-300, 1e-30, 1e30, 1e300}) {
    SparseScene scene = row_of_cameras(2, 0.1);
    for (Eigen::Vector3d& point : scene.points) point = {0, 0, z};
    const DepthRange range = depth_range(scene, 0);
    EXPECT_TRUE(std::isfinite(range.nearest)) << z;
    EXPECT_GT(range.farthest, 0) << z;
    EXPECT_GT(range.nearest, range.farthest) << z;
  }
}

TEST(KeyStride, ShrinksWithMotion) {
  EXPECT_EQ(choose_key_stride(row_of_cameras(20, 1e-4)), 4);
  EXPECT_EQ(choose_key_stride(row_of_cameras(20, 0.1)), 1);
}

TEST(Complete, ContinuesAPlane) {
  RatedDepth depth = flat_depth(0);
  const auto truth = [](int x, int y) { return 0.5F + 0.01F * static_cast<float>(x) + 0.004F * static_cast<float>(y); };
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const bool hole = x >= 12 && x < 36 && y >= 8 && y < 24;
      depth.inverse_depth(x, y) = hole ? 0.0F : truth(x, y);
      depth.confidence(x, y) = hole ? 0.0F : 0.8F;
    }
  }
  complete(even_view(), depth);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      EXPECT_NEAR(depth.inverse_depth(x, y), truth(x, y), 0.01) << x << ", " << y;
      EXPECT_EQ(depth.confidence(x, y) >= 0.5F, !(x >= 12 && x < 36 && y >= 8 && y < 24));
    }
  }
}

TEST(Complete, StopsAtAnEdgeOfColour) {
  View view = even_view();
  RatedDepth depth = flat_depth(0);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      if (x >= 20) view.colour(x, y) = {200, 80, 40};
      if (x < 10) depth.inverse_depth(x, y) = 1;
      if (x >= 40) depth.inverse_depth(x, y) = 2;
    }
  }
  complete(view, depth);
  EXPECT_NEAR(depth.inverse_depth(18, 16), 1, 0.05);
  EXPECT_NEAR(depth.inverse_depth(22, 16), 2, 0.05);
}

TEST(Complete, InventsNothingFromNothing) {
  RatedDepth depth{InverseDepthMap(size), Image<float>(size)};
  complete(even_view(), depth);
  for (const float w : depth.inverse_depth.pixels()) ASSERT_EQ(w, 0);
}

TEST(Upsample, FollowsTheEdgeOfThePicture) {
  // The edge of colour lies at 25 of the 96 columns, between coarse pixels 12 and 13, of which 12 is mixed.
  View view = even_view();
  RatedDepth depth = flat_depth(1);
  ImageRgb frame(96, 64, Rgb8{80, 80, 80});
  for (int y = 0; y < 64; ++y)
    for (int x = 25; x < 96; ++x) frame(x, y) = {220, 30, 30};
  for (int y = 0; y < size.height; ++y) {
    view.colour(12, y) = {150, 55, 55};
    for (int x = 13; x < size.width; ++x) view.colour(x, y) = {220, 30, 30};
    for (int x = 12; x < size.width; ++x) depth.inverse_depth(x, y) = 3;
  }
  const RatedDepth out = upsample(view, depth, frame, 0.02);
  for (int x = 0; x < 96; ++x) {
    const float w = out.inverse_depth(x, 30);
    EXPECT_TRUE(w == 1 || w == 3) << x << ": " << w;
    // Column 24 is mixed in the coarse picture and may be either.
    if (x != 24) {
      EXPECT_EQ(w, x < 25 ? 1 : 3) << x;
    }
  }
}

/// Red from column 24 on.
ImageRgb halves() {
  ImageRgb picture(size, Rgb8{80, 80, 80});
  for (int y = 0; y < size.height; ++y)
    for (int x = 24; x < size.width; ++x) picture(x, y) = {220, 30, 30};
  return picture;
}

TEST(SnapToEdges, PutsAStepBackOnTheOutline) {
  for (const int spread : {-3, -1, 0, 2, 3}) {
    InverseDepthMap depth(size, 1);
    for (int y = 0; y < size.height; ++y)
      for (int x = 24 + spread; x < size.width; ++x) depth(x, y) = 2;
    snap_to_edges(halves(), depth);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x) ASSERT_EQ(depth(x, y), x < 24 ? 1 : 2) << spread << ": " << x << ", " << y;
  }
}

TEST(SnapToEdges, LeavesWhatHasNoStep) {
  InverseDepthMap slope(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) slope(x, y) = 1 + 0.02F * static_cast<float>(x);
  InverseDepthMap after = slope;
  snap_to_edges(halves(), after);
  EXPECT_TRUE(after == slope);
}

TEST(SnapToEdges, KnowsNothingOfWhatIsUnknown) {
  InverseDepthMap depth(size, 0.0F);
  for (int y = 4; y < 9; ++y)
    for (int x = 20; x < 30; ++x) depth(x, y) = x < 25 ? 1e-9F : 1e9F;
  const InverseDepthMap before = depth;
  snap_to_edges(halves(), depth);
  for (std::size_t i = 0; i < size.pixels(); ++i) {
    ASSERT_EQ(depth.data()[i] > 0, before.data()[i] > 0);
    ASSERT_TRUE(std::isfinite(depth.data()[i]));
  }
  InverseDepthMap one(1, 1, 0.5F);
  snap_to_edges(ImageRgb(1, 1), one);
  EXPECT_EQ(one(0, 0), 0.5F);
}

TEST(Speckles, GoAndLargePatchesStay) {
  RatedDepth depth = flat_depth(1);
  depth.inverse_depth(5, 5) = depth.inverse_depth(6, 5) = 2;
  for (int y = 10; y < 20; ++y)
    for (int x = 10; x < 20; ++x) depth.inverse_depth(x, y) = 2;
  remove_speckles(depth, 10, 0.02);
  EXPECT_EQ(depth.inverse_depth(5, 5), 0);
  EXPECT_EQ(depth.confidence(6, 5), 0);
  EXPECT_EQ(depth.inverse_depth(15, 15), 2);
  EXPECT_EQ(depth.inverse_depth(0, 0), 1);
}

TEST(Carry, KeepsAWallAndLetsTheNearerSurfaceWin) {
  const View before = even_view(0);
  const View after = even_view(0.1);
  RatedDepth wall = flat_depth(0.5F);
  for (int y = 10; y < 20; ++y)
    for (int x = 20; x < 28; ++x) wall.inverse_depth(x, y) = 1;
  const RatedDepth out = carry(even_view(0.01), {{&before, &wall}, {&after, &wall}}, 0.02);
  EXPECT_EQ(out.inverse_depth(24, 15), 1);
  EXPECT_EQ(out.inverse_depth(4, 4), 0.5F);
  EXPECT_FLOAT_EQ(out.confidence(24, 15), 0.9F);
}

TEST(Confirm, NeedsAnotherViewThatAgrees) {
  const View reference = even_view(0);
  const View other = even_view(0.1);
  const MatchedDepth one{InverseDepthMap(size, 1), Image<float>(size, 0.5F), Image<float>(size)};
  const MatchedDepth same = one;
  const MatchedDepth different{InverseDepthMap(size, 1.05F), Image<float>(size, 0.5F), Image<float>(size)};
  EXPECT_GE(confirm({&reference, &one}, {{&other, &same}}, 0.02).confidence(30, 16), 0.5F);
  EXPECT_EQ(confirm({&reference, &one}, {{&other, &different}}, 0.02).confidence(30, 16), 0);
  EXPECT_EQ(confirm({&reference, &one}, {}, 0.02).inverse_depth(30, 16), 0);
  const MatchedDepth vague{InverseDepthMap(size, 1), Image<float>(size, 0.001F), Image<float>(size)};
  EXPECT_EQ(confirm({&reference, &vague}, {{&other, &same}}, 0.02).confidence(30, 16), 0);
}

}  // namespace
}  // namespace uwv::mvs
