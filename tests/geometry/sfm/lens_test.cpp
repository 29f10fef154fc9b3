// SPDX-License-Identifier: Apache-2.0
// Lenses found, and lenses given that cannot be the clip's.
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/sfm/clips.h"

namespace uwv::testing {
namespace {

double fov_deg(const Intrinsics& lens) { return 2 * std::atan(0.5 * clip_size.width / lens.fx) / degree; }

Clip orbit_in_room(double fov) {
  StockScene room = boxes_room(small_clip());
  room.source.intrinsics = Intrinsics::from_fov_x(fov * degree, clip_size);
  return film(room, 14, [&](int i, const Camera& source) {
    return orbit_camera(source, room.subject_in_world, 1.2 * degree * i);
  });
}

SfmOptions with_fov(double fov) {
  SfmOptions out;
  out.intrinsics = Intrinsics::from_fov_x(fov * degree, clip_size);
  return out;
}

TEST(SfmLens, OrdinaryLensesAreFound) {
  for (const double fov : {40.0, 60.0, 95.0}) {
    const Clip clip = orbit_in_room(fov);
    const SfmResult result = solve(clip);
    ASSERT_EQ(result.motion, ClipMotion::moving) << fov << ": " << result.brief();
    EXPECT_TRUE(result.focal_estimated);
    EXPECT_FALSE(result.lens_doubt);
    EXPECT_NEAR(fov_deg(result.cameras.front().intrinsics), fov, 0.1 * fov);
  }
}

TEST(SfmLens, AWildlyWrongLensIsUsedButNotSilently) {
  const Clip clip = orbit_in_room(60);
  for (const double fov : {5.0, 20.0, 110.0, 170.0}) {
    const SfmResult result = solve(clip, with_fov(fov));
    ASSERT_TRUE(result.lens_doubt) << fov << ": " << result.brief();
    EXPECT_NEAR(result.lens_doubt->given_fov_deg, fov, 1e-6);
    EXPECT_LT(result.parallax_px, clip_size.width / 4.0) << "tracks hardly go that far: " << fov;
    EXPECT_NEAR(result.lens_doubt->seen_fov_deg, 60, 8) << fov;
    EXPECT_GT(result.lens_doubt->given_error_px, result.lens_doubt->seen_error_px);
    ASSERT_EQ(result.notes.size(), 1U);
    EXPECT_NE(result.notes[0].find(fmt::format("{:.1f} degrees", fov)), std::string::npos) << result.notes[0];
    EXPECT_NE(result.notes[0].find(fmt::format("{:.1f} degrees", result.lens_doubt->seen_fov_deg)), std::string::npos);
    for (const Camera& camera : result.cameras) EXPECT_NEAR(fov_deg(camera.intrinsics), fov, 1e-6);
  }
}

TEST(SfmLens, ARightLensIsNotDoubted) {
  for (const double fov : {40.0, 60.0, 95.0}) {
    const Clip clip = orbit_in_room(fov);
    for (const double off : {0.95, 1.0, 1.05}) {
      const SfmResult result = solve(clip, with_fov(off * fov));
      EXPECT_FALSE(result.lens_doubt) << fov << " times " << off << ": " << result.notes.front();
      EXPECT_TRUE(result.notes.empty());
    }
  }
}

TEST(SfmLens, APlaneRaisesNoDoubtAboutTheRightLens) {
  const StockScene wall = textured_plane(small_clip());
  const Clip clip = film(wall, 12, [&](int i, const Camera& source) {
    return orbit_camera(source, wall.subject_in_world, 2 * degree * i);
  });
  EXPECT_FALSE(solve(clip, with_lens(clip)).lens_doubt);
}

TEST(SfmLens, AWrongLensIsDoubtedWhereTheCameraOnlyTurns) {
  const StockScene room = boxes_room(small_clip());
  const Clip clip = film(room, 12, [](int i, const Camera& source) {
    return moved(source, {0, 0, 0}, 2.0 * degree * i);
  });
  const double truth = fov_deg(clip.truth.front().intrinsics);
  EXPECT_FALSE(solve(clip, with_lens(clip)).lens_doubt);
  for (const double fov : {15.0, 130.0}) {
    const SfmResult result = solve(clip, with_fov(fov));
    ASSERT_TRUE(result.lens_doubt) << fov << ": " << result.brief();
    EXPECT_NEAR(result.lens_doubt->seen_fov_deg, truth, 0.3 * truth);
  }
}

}  // namespace
}  // namespace uwv::testing
