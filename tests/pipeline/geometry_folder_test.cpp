// SPDX-License-Identifier: Apache-2.0
// OUT/geometry: what is written is found again, and what is broken is refused.
#include "pipeline/geometry_folder.h"

#include <gtest/gtest.h>

#include "support/temp_folder.h"
#include "uwv/io/cameras_file.h"
#include "uwv/io/depth_source.h"
#include "uwv/io/frame_source.h"
#include "uwv/io/npy.h"

namespace uwv::pipeline {
namespace {

constexpr Size size{20, 14};

EstimatedGeometry some_geometry(long frames) {
  EstimatedGeometry geometry;
  for (long i = 0; i < frames; ++i) {
    FrameGeometry frame{DepthMap(size, 2.0F + static_cast<float>(i)), ConfidenceMap(size, 1.0F)};
    frame.depth(3, 4) = 0;
    frame.confidence(3, 4) = 0;
    frame.confidence(5, 6) = 0.5F;
    geometry.scene.frames.push_back(frame);
    Camera camera{Intrinsics::from_fov_x(1, size), {}, size};
    camera.world_from_cam.translation.x() = static_cast<double>(i);
    geometry.scene.cameras.push_back(camera);
  }
  geometry.facts = {{"provider", "sfm"}};
  return geometry;
}

TEST(GeometryFolder, FindsWhatWasWritten) {
  const test::TempFolder folder;
  Monitor monitor;
  const GeometryFolder written{.path = folder.file("geometry"), .start = 4, .stride = 2, .frames = 3};
  write_geometry_folder(written, some_geometry(3), 25, monitor);

  const auto found = open_geometry_folder(written.path);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->start, 4);
  EXPECT_EQ(found->stride, 2);
  EXPECT_EQ(found->frames, 3);
  EXPECT_FALSE(found->has_foreground);
  EXPECT_FALSE(found->has_background);
  EXPECT_EQ(found->foreground(), "");

  const auto depths = open_depth(found->depth(), {}, monitor);
  DepthMap depth;
  ASSERT_EQ(depths->frames(), 3);
  ASSERT_TRUE(depths->read(2, depth));
  EXPECT_EQ(depth(0, 0), 4.0F);
  EXPECT_EQ(depth(3, 4), 0.0F);
  const CameraTrack track = read_cameras(found->cameras(), {.size = size, .intrinsics = {}}, monitor);
  ASSERT_EQ(track.cameras.size(), 3U);
  EXPECT_EQ(track.cameras[2].world_from_cam.translation.x(), 2);
  NpyArrayReader confidences(found->path + "/confidence.npz", "confidence");
  std::vector<float> values(size.pixels());
  confidences.read(1, std::span<float>(values));
  EXPECT_EQ(values[0], 255);
  EXPECT_EQ(values[6 * 20 + 5], 128) << "half is still a measurement";
  EXPECT_EQ(values[4 * 20 + 3], 0);
}

TEST(GeometryFolder, KeepsForegroundAndBackground) {
  const test::TempFolder folder;
  Monitor monitor;
  EstimatedGeometry geometry = some_geometry(2);
  geometry.foreground.assign(2, ForegroundMask(size));
  geometry.foreground[1](7, 8) = 1;
  geometry.background = {{2, ImageRgb(size, {10, 200, 30})}, {2, DepthMap(size, 9.0F)}};
  const GeometryFolder written{.path = folder.file("geometry"), .frames = 2};
  write_geometry_folder(written, geometry, 25, monitor);

  const auto found = open_geometry_folder(written.path);
  ASSERT_TRUE(found && found->has_foreground && found->has_background);
  ImageRgb picture;
  ClipOptions as_it_is;
  as_it_is.resize.mode = ResizePolicy::Mode::none;
  const auto masks = open_clip(found->foreground(), as_it_is, monitor);
  ASSERT_TRUE(masks->read(1, picture));
  EXPECT_EQ(picture(7, 8), (Rgb8{255, 255, 255}));
  EXPECT_EQ(picture(6, 8), (Rgb8{0, 0, 0}));
  const auto background = open_clip(found->background(), as_it_is, monitor);
  ASSERT_TRUE(background->read(0, picture));
  EXPECT_NEAR(picture(5, 5).g, 200, 4);
  DepthMap depth;
  ASSERT_TRUE(open_depth(found->background_depth(), {}, monitor)->read(1, depth));
  EXPECT_EQ(depth(0, 0), 9.0F);
}

TEST(GeometryFolder, IsNothingElse) {
  const test::TempFolder folder;
  folder.write("file", "no folder");
  EXPECT_FALSE(open_geometry_folder(""));
  EXPECT_FALSE(open_geometry_folder(folder.file("none")));
  EXPECT_FALSE(open_geometry_folder(folder.file("file")));
  EXPECT_FALSE(open_geometry_folder(folder.file("")));
}

TEST(GeometryFolder, RefusesBrokenDescriptions) {
  const test::TempFolder folder;
  for (const char* text : {"", "[]", "{", R"({"start": 0, "stride": 1})", R"({"start": -1, "stride": 1, "frames": 3})",
                           R"({"start": 0, "stride": 0, "frames": 3})", R"({"start": 0, "stride": 1, "frames": "3"})",
                           R"({"start": 0, "stride": 1, "frames": 1.5})"}) {
    folder.write("geometry.json", text);
    try {
      open_geometry_folder(folder.file("."));
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::file_damaged) << text;
      EXPECT_NE(std::string(error.what()).find("geometry.json"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace uwv::pipeline
