// SPDX-License-Identifier: Apache-2.0
#include "uwv/model/depth_network.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "model/script_nets.h"
#include "support/recording_monitor.h"

namespace uwv {
namespace {

using test::NetFolder;
using testing::HasSubstr;

/// Grey frames: 40 for the first, 1 more for each further one.
std::vector<ImageRgb> grey_frames(Size size, int count) {
  std::vector<ImageRgb> frames;
  for (int i = 0; i < count; ++i) {
    const auto level = static_cast<std::uint8_t>(40 + i);
    frames.emplace_back(size, Rgb8{level, level, level});
  }
  return frames;
}

DepthNetworkResult run(const NetFolder& net, const std::vector<ImageRgb>& frames,
                       test::RecordingMonitor* monitor = nullptr, int threads = 1) {
  ThreadPool pool(threads);
  test::RecordingMonitor unheard;
  return open_depth_network(net.path())->run(frames, {}, pool, monitor != nullptr ? *monitor : unheard);
}

/// A scene whose depth is 1 + the red channel: the network's answer is known for any picture.
constexpr const char* red_depth = "def forward(self, x):\n    return 1.0 + x[:, 0]\n";
constexpr const char* metric_manifest = R"({"format": 1, "name": "red", "kind": "metric_depth",
  "input": {"resize": "longer_side", "side": 32, "multiple_of": 4, "filter": "bilinear"}, "outputs": {"depth": 0}})";

TEST(DepthNetwork, of_metric_depth_says_what_the_net_said) {
  const NetFolder net(red_depth, metric_manifest);
  const auto network = open_depth_network(net.path());
  EXPECT_EQ(network->name(), "red");
  EXPECT_EQ(network->meaning(), NetworkDepth::metric);
  EXPECT_EQ(network->input_size({64, 48}), (Size{32, 24}));

  ImageRgb ramp(64, 48);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) ramp(x, y) = {static_cast<std::uint8_t>(4 * x), 7, 9};
  const DepthNetworkResult result = run(net, {ramp});
  ASSERT_EQ(result.frames.size(), 1U);
  EXPECT_TRUE(result.consistent);
  EXPECT_TRUE(result.intrinsics.empty());
  EXPECT_GT(result.peak_bytes, 1U << 20);
  for (int y = 0; y < 48; ++y)
    for (int x = 2; x < 62; ++x) {
      EXPECT_NEAR(result.frames[0].depth(x, y), 1 + 4 * x / 255.0, 1e-5) << x << "," << y;
      EXPECT_EQ(result.frames[0].confidence(x, y), 0.5F);
    }
}

TEST(DepthNetwork, gives_the_same_bits_on_any_number_of_threads) {
  const NetFolder net(red_depth, metric_manifest);
  const auto frames = grey_frames({50, 30}, 5);
  const auto one = run(net, frames, nullptr, 1), three = run(net, frames, nullptr, 3);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(one.frames[i].depth, three.frames[i].depth);
}

TEST(DepthNetwork, takes_dictionaries_channels_last_and_half_weights) {
  const NetFolder net(
      "def forward(self, x):\n    return {'d': x[:, :, :, 0:1] * 2.0 + 1.0, 'other': x}\n",
      R"({"format": 1, "kind": "metric_depth", "unit": "relative", "input": {"resize": "fixed", "size": [8, 6],
                      "layout": "NHWC", "dtype": "bfloat16"}, "outputs": {"depth": "d"}})");
  const auto result = run(net, grey_frames({8, 6}, 2));
  EXPECT_EQ(result.meaning, NetworkDepth::up_to_scale);
  EXPECT_FALSE(result.consistent);
  EXPECT_NEAR(result.frames[1].depth(3, 3), 1 + 2 * 41 / 255.0, 0.01);
}

TEST(DepthNetwork, scales_its_intrinsics_to_the_frame) {
  const NetFolder net(
      "def forward(self, x):\n    k = torch.tensor([[20.0, 0.0, 16.0], [0.0, 22.0, 6.0], [0.0, 0.0, 1.0]])\n"
      "    return {'d': x[:, 0] + 1.0, 'k': k.unsqueeze(0)}\n",
      R"({"format": 1, "kind": "metric_depth", "input": {"resize": "fixed", "size": [32, 12]},
                      "outputs": {"depth": "d", "intrinsics": "k"}})");
  const auto result = run(net, grey_frames({64, 48}, 1));
  EXPECT_EQ(result.intrinsics.at(0), (Intrinsics{40, 88, 32, 24}));
}

TEST(DepthNetwork, marks_what_is_no_depth_as_unknown) {
  const NetFolder net(
      R"(
def forward(self, x):
    d = x[0, 0] * 0.0 + 3.0
    d[0, 0] = float('nan')
    d[0, 1] = float('inf')
    d[0, 2] = -1.0
    d[0, 3] = 0.0
    d[0, 4] = 99.0
    mask = x[0, 0] * 0.0 + 1.0
    mask[1, 0] = 0.0
    confidence = x[0, 0] * 0.0 + 4.0
    confidence[1, 1] = float('nan')
    return d, mask, confidence
)",
      R"({"format": 1, "kind": "metric_depth", "input": {"resize": "fixed", "size": [6, 4]}, "max_depth": 50,
    "outputs": {"depth": 0, "mask": 1, "confidence": 2}, "confidence_rule": "from_one"})");
  test::RecordingMonitor monitor;
  const auto result = run(net, grey_frames({6, 4}, 1), &monitor);
  const FrameGeometry& frame = result.frames[0];
  for (int x = 0; x < 5; ++x) {
    EXPECT_EQ(frame.depth(x, 0), 0) << x;
    EXPECT_EQ(frame.confidence(x, 0), 0) << x;
  }
  EXPECT_EQ(frame.depth(0, 1), 0) << "masked";
  EXPECT_EQ(frame.depth(1, 1), 3);
  EXPECT_NEAR(frame.confidence(1, 1), 1e-3, 1e-6) << "a known depth keeps a little";
  EXPECT_EQ(frame.confidence(5, 3), 0.75F);
  ASSERT_EQ(monitor.warnings.size(), 1U);
  EXPECT_THAT(monitor.warnings[0], HasSubstr("NaN or infinity for 2 of 24 pixels"));
}

TEST(DepthNetwork, that_knows_nothing_says_so) {
  const NetFolder net("def forward(self, x):\n    return x[:, 0] * float('nan')\n", metric_manifest);
  test::RecordingMonitor monitor;
  const auto result = run(net, grey_frames({6, 4}, 2), &monitor);
  EXPECT_EQ(result.frames[1].depth(2, 2), 0);
  ASSERT_FALSE(monitor.warnings.empty());
  EXPECT_THAT(monitor.warnings[0], HasSubstr("no depth at all in 2 of 2 frames"));
}

TEST(DepthNetwork, of_inverse_depth_keeps_zeros_and_negative_values) {
  const NetFolder net("def forward(self, x):\n    return x[:, 0:1] - x[:, 0:1].mean()\n",
                      R"({"format": 1, "kind": "inverse_depth", "input": {"resize": "fixed", "size": [2, 2]},
                      "outputs": {"inverse_depth": 0}})");
  ImageRgb frame(2, 2);
  frame(0, 0) = {255, 0, 0};
  const auto result = run(net, {frame});
  EXPECT_EQ(result.meaning, NetworkDepth::inverse_affine);
  EXPECT_EQ(result.frames[0].depth(0, 0), 0.75F);
  EXPECT_EQ(result.frames[0].depth(1, 1), -0.25F);
  EXPECT_EQ(result.frames[0].confidence(1, 1), 0.5F);
  EXPECT_FALSE(run(net, {frame, frame}).consistent) << "each frame has a scale of its own";
}

/// Points of a bowl seen with focal length 1.2 widths, without 0.7 of their depth and at half their size.
constexpr const char* bowl = R"(
def forward(self, x):
    h = x.size(2)
    w = x.size(3)
    u = ((torch.arange(w) + 0.5) / w - 0.5).unsqueeze(0).expand(h, w)
    v = (((torch.arange(h) + 0.5) / h - 0.5) * 0.75).unsqueeze(1).expand(h, w)
    z = 3.0 + u * u * 4.0 + v
    points = torch.stack([u / 1.2 * z, v / 1.2 * z, z - 0.7], 2) * 0.5
    normal = torch.stack([u * 0.0, u * 0.0, u * 0.0 + 2.0], 2)
    mask = (v < 0.3) * 1.0
    points[0, 0, 0] = float('nan')
    return points.unsqueeze(0), normal.unsqueeze(0), mask.unsqueeze(0), torch.tensor([2.0])
)";

TEST(DepthNetwork, of_points_recovers_focal_length_and_depth) {
  const NetFolder net(bowl, R"({"format": 1, "kind": "points", "input": {"resize": "longer_side", "side": 56},
    "outputs": {"points": 0, "normals": 1, "mask": 2, "metric_scale": 3}})");
  const auto result = run(net, grey_frames({112, 84}, 1));
  EXPECT_EQ(result.meaning, NetworkDepth::metric);
  ASSERT_EQ(result.intrinsics.size(), 1U);
  EXPECT_NEAR(result.intrinsics[0].fx, 1.2 * 112, 0.02);
  EXPECT_EQ(result.intrinsics[0].fx, result.intrinsics[0].fy);
  EXPECT_EQ(result.intrinsics[0].cx, 56);
  for (const auto& [x, y] : {std::pair{20, 30}, {56, 42}, {100, 10}}) {
    const double u = (x + 0.5) / 112 - 0.5, v = ((y + 0.5) / 84 - 0.5) * 0.75;
    EXPECT_NEAR(result.frames[0].depth(x, y), 3 + 4 * u * u + v, 2e-3) << x << "," << y;
  }
  EXPECT_EQ(result.frames[0].confidence(50, 80), 0) << "outside the mask";
  EXPECT_EQ(result.normals[0](50, 40), Eigen::Vector3f(0, 0, -1)) << "turned to face the camera, of unit length";
}

/// Two frames: the second camera stands 2 to the right and looks 0.2 rad to the left of the first.
constexpr const char* two_views = R"(
def forward(self, x):
    t = x.size(1)
    h = x.size(3)
    w = x.size(4)
    depth = torch.ones([1, t, h, w, 1]) * 5.0
    pose = torch.zeros([1, t, 9])
    pose[:, :, 6] = 1.0
    pose[:, :, 7] = 1.0
    pose[:, :, 8] = 1.4
    pose[0, 0, 2] = 3.0
    pose[0, 1, 0] = -2.0
    pose[0, 1, 2] = 3.0
    pose[0, 1, 4] = torch.sin(torch.tensor(0.1))
    pose[0, 1, 6] = torch.cos(torch.tensor(0.1))
    pose[0, 1, 8] = 1.2
    return {"depth": depth, "pose_enc": pose, "depth_conf": depth}
)";

constexpr const char* two_views_manifest = R"({"format": 1, "kind": "depth_and_pose", "unit": "relative",
  "input": {"resize": "width", "side": 28, "multiple_of": 14, "layout": "NTCHW"},
  "outputs": {"depth": "depth", "pose": "pose_enc", "confidence": "depth_conf"}, "confidence_rule": "from_one")";

TEST(DepthNetwork, of_poses_gives_cameras_that_start_at_the_identity) {
  const NetFolder net(two_views, std::string(two_views_manifest) + "}");
  const auto result = run(net, grey_frames({56, 42}, 2));
  EXPECT_TRUE(result.consistent);
  ASSERT_EQ(result.world_from_cam.size(), 2U);
  EXPECT_EQ(result.world_from_cam[0], Rigid3{});
  // cam1_from_world = [R(0.2 about y) | (-2, 0, 3)], cam0_from_world = [1 | (0, 0, 3)].
  const Rigid3 cam0_from_net{Eigen::Matrix3d::Identity(), {0, 0, 3}};
  const Rigid3 cam1_from_net{Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()).toRotationMatrix(), {-2, 0, 3}};
  const Rigid3 expected = cam0_from_net * cam1_from_net.inverse();
  EXPECT_LT((result.world_from_cam[1].rotation - expected.rotation).norm(), 1e-6);
  EXPECT_LT((result.world_from_cam[1].translation - expected.translation).norm(), 1e-5);
  EXPECT_NEAR(result.intrinsics[0].fx, 28 / std::tan(0.7), 1e-4);
  EXPECT_NEAR(result.intrinsics[1].fx, 28 / std::tan(0.6), 1e-4);
  EXPECT_NEAR(result.intrinsics[1].fy, 21 / std::tan(0.5), 1e-4);
  EXPECT_EQ(result.frames[1].depth(10, 10), 5);
  EXPECT_NEAR(result.frames[1].confidence(10, 10), 0.8, 1e-6);
}

TEST(DepthNetwork, one_field_of_view_is_the_first_frames) {
  const NetFolder net(two_views, std::string(two_views_manifest) + R"(, "field_of_view": "first_frame"})");
  const auto result = run(net, grey_frames({56, 42}, 2));
  EXPECT_EQ(result.intrinsics[0], result.intrinsics[1]);
}

TEST(DepthNetwork, on_video_joins_windows_that_differ_by_scale_and_shift) {
  // Each call's values are stretched by its brightest picture, so every window has another scale and shift.
  const NetFolder net(
      R"(
def forward(self, x):
    h = x.size(3)
    w = x.size(4)
    ramp = ((torch.arange(w) + 0.5) / w).unsqueeze(0).expand(h, w)
    values = x[:, :, 0] * 20.0 + ramp
    return values * (1.0 + x.max()) + x.max() * 3.0
)",
      R"({"format": 1, "kind": "inverse_depth", "input": {"resize": "fixed", "size": [16, 8], "layout": "NTCHW"},
    "outputs": {"inverse_depth": 0}, "window": {"frames": 8, "overlap": 4, "blend": 3, "keyframes": [0, 5, 6, 7]}})");
  const auto frames = grey_frames({16, 8}, 21);
  const auto result = run(net, frames);
  ASSERT_EQ(result.frames.size(), 21U);
  EXPECT_TRUE(result.consistent);
  const double brightest = 47 / 255.0;  // of the first window, whose scale and shift hold for all
  for (int f = 0; f < 21; ++f) {
    const double value = 20 * (40 + f) / 255.0 + 4.5 / 16;
    EXPECT_NEAR(result.frames[static_cast<std::size_t>(f)].depth(4, 4), value * (1 + brightest) + 3 * brightest, 2e-4)
        << f;
  }
}

TEST(DepthNetwork, stops_when_the_monitor_says_so) {
  struct Stopper : Monitor {
    bool progress(std::string_view, long done, long) override { return done < 2; }
  } stopper;
  const NetFolder net(red_depth, metric_manifest);
  ThreadPool pool(1);
  try {
    open_depth_network(net.path())->run(grey_frames({8, 8}, 5), {}, pool, stopper);
    FAIL() << "was not stopped";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
  }
}

TEST(DepthNetwork, refuses_a_callers_mistakes) {
  const NetFolder net(red_depth, metric_manifest);
  const auto network = open_depth_network(net.path());
  ThreadPool pool(1);
  Monitor monitor;
  auto mixed = grey_frames({8, 8}, 1);
  mixed.push_back(ImageRgb(9, 8));
  EXPECT_THROW(network->run({}, {}, pool, monitor), std::invalid_argument);
  EXPECT_THROW(network->run(mixed, {}, pool, monitor), std::invalid_argument);
  DepthNetworkOptions options;
  options.threads = -1;
  EXPECT_THROW(network->run(grey_frames({8, 8}, 1), options, pool, monitor), std::invalid_argument);
}

}  // namespace
}  // namespace uwv
