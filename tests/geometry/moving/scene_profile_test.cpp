// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/scene_profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace uwv::testing {
namespace {

using ::testing::HasSubstr;

/// A clip with everything there is to measure.
SceneProfile rich() {
  SceneProfile p;
  p.size = {832, 480};
  p.frames = 25;
  p.motion = ClipMotion::moving;
  p.parallax_px = 24;
  p.rms_error_px = 0.4;
  p.registered_share = 1;
  p.moving_share = 0;
  p.measured_share = 0.8;
  p.disocclusion_share = 0.1;
  p.depth_ratio = 4;
  return p;
}

GeometryPlan plan(const SceneProfile& p, const GeometryPlanOptions& options = {}) { return plan_geometry(p, options); }

TEST(GeometryPlanTest, ARichClipIsMeasuredMergedAndLayered) {
  const GeometryPlan got = plan(rich());
  EXPECT_EQ(got.provider.choice, GeometryProvider::sfm);
  EXPECT_THAT(got.provider.reason, HasSubstr("24.0 px"));
  EXPECT_EQ(got.cloud.choice, CloudKind::merged);
  EXPECT_TRUE(got.layers.choice);
  EXPECT_EQ(got.key_stride.choice, 2);  // 1 px a frame, 2 allowed
  EXPECT_THAT(got.key_stride.saves, HasSubstr("12 of 25"));
  EXPECT_FALSE(got.decimate.choice);  // drawing is no faster
  EXPECT_TRUE(got.notes.empty());
  EXPECT_EQ(got.brief(), "depth from sfm, merged cloud, two layers, depth every 2 frame(s), all points");
}

TEST(GeometryPlanTest, EachLackOfEvidenceLeavesDepthToThePrior) {
  struct Case {
    void (*spoil)(SceneProfile&);
    const char* reason;
  };
  for (const Case& c : {Case{[](SceneProfile& p) { p.frames = 1; }, "1 frame"},
                        Case{[](SceneProfile& p) { p.motion = ClipMotion::turning; }, "only turns"},
                        Case{[](SceneProfile& p) { p.motion = ClipMotion::still; }, "stands still"},
                        Case{[](SceneProfile& p) { p.motion = ClipMotion::indeterminate; }, "could not be told"},
                        Case{[](SceneProfile& p) { p.parallax_px = 1.99; }, "1.99 px"},
                        Case{[](SceneProfile& p) { p.rms_error_px = 2.5; }, "2.50 px"},
                        Case{[](SceneProfile& p) { p.registered_share = 0.4; }, "40 %"},
                        Case{[](SceneProfile& p) { p.moving_share = 0.6; }, "60 %"}}) {
    SceneProfile p = rich();
    c.spoil(p);
    const GeometryPlan got = plan(p);
    EXPECT_EQ(got.provider.choice, GeometryProvider::prior) << c.reason;
    EXPECT_THAT(got.provider.reason, HasSubstr(c.reason));
    EXPECT_EQ(got.cloud.choice, CloudKind::per_frame) << c.reason;
    EXPECT_EQ(got.key_stride.choice, 1) << c.reason;
    EXPECT_FALSE(got.decimate.choice) << c.reason;
  }
}

TEST(GeometryPlanTest, CloudsStayApartWhereMergingHasNoUse) {
  struct Case {
    void (*change)(SceneProfile&);
    const char* reason;
  };
  for (const Case& c : {Case{[](SceneProfile& p) { p.cuts = 1; }, "1 cut"},
                        Case{[](SceneProfile& p) { p.measured_share = 0.1; }, "10 %"},
                        Case{[](SceneProfile& p) { p.disocclusion_share = 0.01; }, "1.0 %"}}) {
    SceneProfile p = rich();
    c.change(p);
    const GeometryPlan got = plan(p);
    EXPECT_EQ(got.provider.choice, GeometryProvider::sfm) << c.reason;
    EXPECT_EQ(got.cloud.choice, CloudKind::per_frame) << c.reason;
    EXPECT_THAT(got.cloud.reason, HasSubstr(c.reason));
  }
  SceneProfile early = rich();
  early.measured_share = 0;  // not measured yet
  EXPECT_EQ(plan(early).cloud.choice, CloudKind::merged);
}

TEST(GeometryPlanTest, CloudOfOtherProvidersFollowsTheClip) {
  GeometryPlanOptions network;
  network.provider = GeometryProvider::network;
  SceneProfile p = rich();
  EXPECT_EQ(plan(p, network).cloud.choice, CloudKind::merged);
  p.motion = ClipMotion::turning;
  EXPECT_EQ(plan(p, network).cloud.choice, CloudKind::per_frame);
  p = rich();
  p.moving_share = 0.7;
  EXPECT_EQ(plan(p, network).cloud.choice, CloudKind::per_frame);
  p = rich();
  p.frames = 1;
  EXPECT_EQ(plan(p, network).cloud.choice, CloudKind::per_frame);
  EXPECT_EQ(plan(rich(), network).key_stride.choice, 1);
}

TEST(GeometryPlanTest, LayersAreForWhatMovesOrUncovers) {
  SceneProfile p = rich();
  p.depth_ratio = 1.2;
  EXPECT_FALSE(plan(p).layers.choice);
  EXPECT_THAT(plan(p).layers.reason, HasSubstr("flat"));
  p.moving_share = 0.03;
  EXPECT_TRUE(plan(p).layers.choice);
  EXPECT_THAT(plan(p).layers.reason, HasSubstr("3.0 %"));
  p = rich();
  p.disocclusion_share = 0;
  EXPECT_FALSE(plan(p).layers.choice);
}

TEST(GeometryPlanTest, TheStrideFollowsTheParallaxOfAFrame) {
  for (const auto& [parallax, stride] : {std::pair{2.0, 4}, {16.0, 3}, {96.0, 1}, {9600.0, 1}}) {
    SceneProfile p = rich();
    p.parallax_px = parallax;
    EXPECT_EQ(plan(p).key_stride.choice, stride) << parallax;
  }
  SceneProfile p = rich();
  p.parallax_per_frame_px = 0.7;  // measured from frame to frame, it is better than the clip's spread evenly
  EXPECT_EQ(plan(p).key_stride.choice, 2);
  p = rich();
  p.frames = 4;
  p.parallax_px = 2;
  EXPECT_EQ(plan(p).key_stride.choice, 3);
  p.frames = 2;
  EXPECT_EQ(plan(p).key_stride.choice, 1);
}

TEST(GeometryPlanTest, PointsAreThinnedOutOnlyWhenAsked) {
  GeometryPlanOptions asked;
  asked.decimate = true;
  EXPECT_FALSE(plan(rich()).decimate.choice);
  EXPECT_THAT(plan(rich()).decimate.reason, HasSubstr("0.40 million points"));
  EXPECT_TRUE(plan(rich(), asked).decimate.choice);
}

TEST(GeometryPlanTest, EveryDecisionCanBeForcedAndSaysWhatTheNumbersSay) {
  GeometryPlanOptions forced;
  forced.provider = GeometryProvider::prior;
  forced.cloud = CloudKind::merged;
  forced.layers = false;
  forced.key_stride = 5;
  forced.decimate = true;
  const GeometryPlan got = plan(rich(), forced);
  EXPECT_EQ(got.provider.choice, GeometryProvider::prior);
  EXPECT_EQ(got.cloud.choice, CloudKind::merged);
  EXPECT_FALSE(got.layers.choice);
  EXPECT_EQ(got.key_stride.choice, 5);
  EXPECT_TRUE(got.decimate.choice);
  EXPECT_TRUE(got.provider.forced && got.cloud.forced && got.layers.forced && got.key_stride.forced &&
              got.decimate.forced);
  EXPECT_THAT(got.provider.reason, HasSubstr("the numbers say otherwise"));
  EXPECT_THAT(got.decimate.reason, HasSubstr("the numbers say otherwise"));
  EXPECT_FALSE(plan(rich()).provider.forced);
}

TEST(GeometryPlanTest, UnusableNumbersAreNotedAndTakenTheSafeWay) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf, -1.0}) {
    for (double SceneProfile::*field :
         {&SceneProfile::parallax_px, &SceneProfile::rms_error_px, &SceneProfile::registered_share,
          &SceneProfile::moving_share, &SceneProfile::measured_share, &SceneProfile::disocclusion_share,
          &SceneProfile::depth_ratio, &SceneProfile::parallax_per_frame_px}) {
      SceneProfile p = rich();
      p.*field = bad;
      const GeometryPlan got = plan(p);
      EXPECT_EQ(got.notes.size(), 1U);
      EXPECT_GE(got.key_stride.choice, 1);
    }
    SceneProfile p = rich();
    p.parallax_px = bad;
    EXPECT_EQ(plan(p).provider.choice, GeometryProvider::prior);
    p = rich();
    p.rms_error_px = bad;
    EXPECT_EQ(plan(p).provider.choice, GeometryProvider::prior);
  }
  const GeometryPlan nothing = plan(SceneProfile{});
  EXPECT_EQ(nothing.provider.choice, GeometryProvider::prior);
  EXPECT_EQ(nothing.cloud.choice, CloudKind::per_frame);
  EXPECT_FALSE(nothing.layers.choice);
  SceneProfile negative = rich();
  negative.frames = -3, negative.cuts = -1, negative.size = {-5, 7};
  EXPECT_EQ(plan(negative).notes.size(), 3U);
}

TEST(GeometryPlanTest, EveryDecisionExplainsItself) {
  for (const SceneProfile& p : {rich(), SceneProfile{}}) {
    const GeometryPlan got = plan(p);
    for (const std::string* text :
         {&got.provider.reason, &got.cloud.reason, &got.layers.reason, &got.key_stride.reason, &got.decimate.reason,
          &got.provider.saves, &got.cloud.saves, &got.layers.saves, &got.key_stride.saves, &got.decimate.saves})
      EXPECT_FALSE(text->empty());
    EXPECT_FALSE(p.brief().empty());
  }
}

TEST(GeometryPlanTest, OptionsOutOfRangeAreRefused) {
  GeometryPlanOptions options;
  options.key_stride = 0;
  EXPECT_THROW(plan(rich(), options), std::invalid_argument);
  options = {};
  options.min_parallax_px = std::nan("");
  EXPECT_THROW(plan(rich(), options), std::invalid_argument);
  options = {};
  options.max_moving_share = 1.5;
  EXPECT_THROW(plan(rich(), options), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::testing
