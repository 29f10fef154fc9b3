// SPDX-License-Identifier: Apache-2.0
// The main job as a user meets it: results, help, resuming, repeating, comparing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/clip_maker.h"
#include "apps/program.h"
#include "uwv/io/frame_source.h"
#include "uwv/io/image_file.h"
#include "uwv/io/npy.h"
#include "uwv/io/ply_file.h"
#include "uwv/pipeline/option_table.h"

namespace uwv::test {
namespace {

namespace fs = std::filesystem;
using testing::ContainsRegex;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Key;
using testing::Not;

class UwvApp : public testing::Test {
 protected:
  Outcome app(const std::vector<std::string>& arguments) const { return run_app(folder_.path().string(), arguments); }
  /// Runs and expects success.
  Outcome must(const std::vector<std::string>& arguments) const {
    const Outcome outcome = app(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err << outcome.out;
    return outcome;
  }
  nlohmann::json record(const std::string& out) const { return nlohmann::json::parse(folder_.read(out + "/run.json")); }
  std::string status_of(const std::string& out, std::size_t stage) const {
    return record(out)["stages"][stage]["status"].get<std::string>();
  }

  TempFolder folder_;
};

TEST_F(UwvApp, HelpNamesEveryOption) {
  const std::string help = must({"--help"}).out;
  for (const OptionInfo& info : option_table()) {
    EXPECT_THAT(help, HasSubstr(info.flag()));
    EXPECT_THAT(help, HasSubstr(info.group));
  }
  for (const char* word : {"doctor", "compare", "look", "--options", "--version", "Example"})
    EXPECT_THAT(help, HasSubstr(word));
}

TEST_F(UwvApp, WritesWhatItPromises) {
  make_clip(folder_, {});
  must(run_arguments("out", {"--save-masks", "--ply", "0,4", "--complete", "inpaint"}));
  EXPECT_THAT(results(folder_.file("out")),
              ElementsAre(Key("cameras_source.json"), Key("cameras_target.json"), Key("colour.mp4"),
                          Key("contact_sheet.png"), Key("depth.npz"), Key("generate_mask.mp4"), Key("mask_first.mp4"),
                          Key("mask_front.mp4"), Key("mask_second.mp4"), Key("mask_visible.mp4"),
                          Key("points_00000.ply"), Key("points_00004.ply"), Key("result.mp4")));
  const auto run = record("out");
  EXPECT_EQ(run["status"], "finished");
  EXPECT_EQ(run["stages"].size(), 5U);
  EXPECT_EQ(run["stages"][1]["frames"], 5);
  EXPECT_GT(run["stages"][1]["peak_bytes"], 1000000);
  EXPECT_EQ(run["options"]["traj"], "left");
  EXPECT_EQ(run["inputs"]["video"]["bytes"], fs::file_size(folder_.file("clip.mp4")));
  EXPECT_EQ(read_ply(folder_.file("out/points_00000.ply")).colours.size(),
            read_ply(folder_.file("out/points_00000.ply")).points.size());
}

TEST_F(UwvApp, MaskIsExactlyBlackAndWhiteAndAgreesWithDepth) {
  make_clip(folder_, {});
  must(run_arguments("out"));
  Monitor monitor;
  ClipOptions whole;
  whole.resize.mode = ResizePolicy::Mode::none;
  const auto masks = open_clip(folder_.file("out/generate_mask.mp4"), whole, monitor);
  NpyArrayReader depths(folder_.file("out/depth.npz"), "depth");
  ASSERT_EQ(masks->frames(), 5);
  ASSERT_EQ(depths.slices(), 5U);
  ImageRgb mask;
  DepthMap depth(masks->info().size);
  std::size_t holes = 0;
  for (long i = 0; i < masks->frames(); ++i) {
    ASSERT_TRUE(masks->read(i, mask));
    depths.read(static_cast<std::size_t>(i), depth.pixels());
    for (int y = 0; y < mask.height(); ++y)
      for (int x = 0; x < mask.width(); ++x) {
        const Rgb8 expected = depth(x, y) > 0 ? Rgb8{0, 0, 0} : Rgb8{255, 255, 255};
        ASSERT_EQ(mask(x, y), expected) << "frame " << i << " at " << x << "," << y;
        holes += depth(x, y) > 0 ? 0 : 1;
      }
  }
  EXPECT_GT(holes, 0U) << "a moving camera must leave holes behind the square";
}

TEST_F(UwvApp, FirstFrameIsTheSourceAndCanBeItsRendering) {
  make_clip(folder_, {});
  must(run_arguments("kept", {"--crf", "0"}));
  must(run_arguments("drawn", {"--crf", "0", "--no-keep-source", "--reliability", "on"}));
  Monitor monitor;
  ClipOptions whole;
  whole.resize.mode = ResizePolicy::Mode::none;
  ImageRgb kept, drawn;
  ASSERT_TRUE(open_clip(folder_.file("kept/generate_mask.mp4"), whole, monitor)->read(0, kept));
  ASSERT_TRUE(open_clip(folder_.file("drawn/generate_mask.mp4"), whole, monitor)->read(0, drawn));
  EXPECT_EQ(kept, ImageRgb(kept.size()));
  EXPECT_NE(drawn, ImageRgb(drawn.size())) << "the reliability filter leaves holes around the square";
}

TEST_F(UwvApp, EveryRendererWritesTheSameBytes) {
  make_clip(folder_, {});
  must(run_arguments("cpu", {"--renderer", "cpu", "--save-masks", "--fringe", "1"}));
  const std::string machine = must({"doctor"}).out;
  int compared = 0;
  for (const char* backend : {"egl", "osmesa"}) {
    const Outcome outcome =
        app(run_arguments(backend, {"--renderer", "gl", "--gl", backend, "--save-masks", "--fringe", "1"}));
    if (outcome.exit_code != 0) {
      EXPECT_THAT(machine, Not(ContainsRegex(std::string(backend) + "[^\n]* yes:"))) << "but: " << outcome.err;
      continue;
    }
    EXPECT_EQ(results(folder_.file(backend)), results(folder_.file("cpu"))) << backend;
    ++compared;
  }
  if (compared == 0) GTEST_SKIP() << "no OpenGL here: " << machine;
}

TEST_F(UwvApp, SecondRunSkipsWhatIsFinished) {
  make_clip(folder_, {});
  must(run_arguments("out"));
  const auto first = results(folder_.file("out"));
  const auto made = fs::last_write_time(folder_.file("out/colour.mp4"));
  const Outcome again = must(run_arguments("out"));
  EXPECT_THAT(again.out, HasSubstr("was there already"));
  EXPECT_EQ(fs::last_write_time(folder_.file("out/colour.mp4")), made);
  EXPECT_EQ(results(folder_.file("out")), first);
  EXPECT_EQ(status_of("out", 1), "resumed");
  EXPECT_EQ(record("out")["stages"][1]["frames"], 5) << "a resumed stage keeps its figures";
}

TEST_F(UwvApp, OtherOptionsRedoWhatTheyAffect) {
  make_clip(folder_, {});
  must(run_arguments("out"));
  must(run_arguments("out", {"--complete", "inpaint"}));
  EXPECT_EQ(status_of("out", 1), "resumed");
  EXPECT_EQ(status_of("out", 2), "done");
  EXPECT_EQ(status_of("out", 3), "resumed");
  const Outcome other = must(run_arguments("out", {"--complete", "inpaint", "--kernel", "nearest"}));
  EXPECT_THAT(other.out, HasSubstr("made anew"));
  for (std::size_t stage = 1; stage < 4; ++stage) EXPECT_EQ(status_of("out", stage), "done") << stage;
  must(run_arguments("out", {"--kernel", "nearest"}));
  EXPECT_EQ(status_of("out", 2), "skipped");
  EXPECT_FALSE(fs::exists(folder_.file("out/result.mp4"))) << "no result of options that ask for none";
}

TEST_F(UwvApp, ChangedInputIsNoticed) {
  make_clip(folder_, {});
  must(run_arguments("out"));
  make_clip(folder_, {.frames = 4});
  must(run_arguments("out"));
  EXPECT_EQ(status_of("out", 1), "done");
  EXPECT_EQ(record("out")["stages"][1]["frames"], 4);
}

TEST_F(UwvApp, DamagedResultIsMadeAgain) {
  make_clip(folder_, {});
  must(run_arguments("out"));
  const auto first = results(folder_.file("out"));
  fs::resize_file(folder_.file("out/colour.mp4"), 100);
  must(run_arguments("out"));
  EXPECT_EQ(results(folder_.file("out")), first);
}

TEST_F(UwvApp, BytesDoNotDependOnThreads) {
  make_clip(folder_, {});
  must(run_arguments("one", {"--threads", "1", "--complete", "inpaint"}));
  must(run_arguments("three", {"--threads", "3", "--complete", "inpaint"}));
  EXPECT_EQ(results(folder_.file("one")), results(folder_.file("three")));
}

TEST_F(UwvApp, RunRecordRepeatsTheRun) {
  make_clip(folder_, {});
  must(run_arguments("out", {"--kernel", "nearest", "--alpha", "70", "--frames", "3", "--point-size", "1.25"}));
  must({"--options", "out/run.json", "--out", "again"});
  EXPECT_EQ(results(folder_.file("again")), results(folder_.file("out")));
  must({"--options", "out/run.json", "--out", "longer", "--frames", "4"});
  EXPECT_EQ(record("longer")["stages"][1]["frames"], 4);
  EXPECT_EQ(record("longer")["options"]["alpha"], 70);
}

TEST_F(UwvApp, NoLayersIsShortForLayersOff) {
  make_clip(folder_, {});
  must(run_arguments("out", {"--no-layers", "--frames", "1"}));
  EXPECT_EQ(record("out")["options"]["layers"], "off");
  EXPECT_EQ(record("out")["choices"]["layers"]["forced"], true);
  must(run_arguments("on", {"--layers", "on", "--frames", "1"}));
  EXPECT_EQ(record("on")["choices"]["layers"]["choice"], "off") << "there is none to be drawn";
}

TEST_F(UwvApp, APhotoIsAClipOfOneFrame) {
  write_png(folder_.file("photo.png"), clip_picture({}, 0));
  const DepthMap depth = clip_depth({}, 0);
  write_npy<float>(folder_.file("photo.npy"), {48, 64}, depth.pixels());
  must({"--video", "photo.png", "--depth", "photo.npy", "--fov", "60", "--no-resize", "--frames", "7"});
  EXPECT_EQ(record("photo_uwv")["stages"][1]["frames"], 7);
  EXPECT_EQ(record("photo_uwv")["clip"]["is_photo"], true);
}

TEST_F(UwvApp, DisparityBecomesDepth) {
  make_clip(folder_, {.frames = 1});
  DepthMap disparity = clip_depth({}, 0);  // with fx * baseline = 8: depth 2 for disparity 4, depth 4 for disparity 2
  for (float& value : disparity.pixels()) value = 8 / value;
  disparity(0, 0) = std::numeric_limits<float>::quiet_NaN();
  disparity(1, 0) = std::numeric_limits<float>::infinity();
  write_npy<float>(folder_.file("disparity.npy"), {48, 64}, disparity.pixels());
  const std::vector<std::string> common = {"--video", "clip.mp4", "--fx", "64", "--no-resize", "--frames", "3"};
  auto with_depth = common, with_disparity = common;
  with_depth.insert(with_depth.end(), {"--depth", "depth.npz", "--out", "a"});
  with_disparity.insert(with_disparity.end(), {"--disparity", "disparity.npy", "--baseline", "0.125", "--out", "b"});
  must(with_depth);
  must(with_disparity);
  NpyArrayReader a(folder_.file("a/depth.npz"), "depth"), b(folder_.file("b/depth.npz"), "depth");
  std::vector<float> from_depth(64 * 48), from_disparity(64 * 48);
  a.read(0, std::span<float>(from_depth));
  b.read(0, std::span<float>(from_disparity));
  EXPECT_EQ(from_disparity[0], 0) << "NaN is invalid";
  EXPECT_EQ(from_disparity[1], 0) << "infinity is invalid";
  for (std::size_t i = 2; i < from_depth.size(); ++i) ASSERT_FLOAT_EQ(from_depth[i], from_disparity[i]) << i;
}

TEST_F(UwvApp, StaticDepthServesAllFrames) {
  make_clip(folder_, {});
  const DepthMap depth = clip_depth({}, 0);
  write_npy<float>(folder_.file("still.npy"), {48, 64}, depth.pixels());
  const std::vector<std::string> common = {"--video", "clip.mp4", "--depth", "still.npy", "--fov", "60", "--no-resize"};
  auto refused = common, accepted = common;
  accepted.emplace_back("--static-depth");
  const Outcome outcome = app(refused);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("depth for 1 frames, wanted 5"));
  must(accepted);
}

TEST_F(UwvApp, EvaluationComparesWithARealPicture) {
  make_clip(folder_, {.frames = 1});
  Monitor monitor;
  ClipOptions whole;
  whole.resize.mode = ResizePolicy::Mode::none;
  ImageRgb decoded;
  ASSERT_TRUE(open_clip(folder_.file("clip.mp4"), whole, monitor)->read(0, decoded));
  write_png(folder_.file("same.png"), decoded);
  folder_.write("camera.json", R"({"uwv_cameras": 1, "convention": "opencv, world_from_cam, pixel centres at +0.5",
    "width": 64, "height": 48, "frames": [{"index": 0, "time": 0, "fx": 64, "fy": 64, "cx": 32, "cy": 24,
    "world_from_cam": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]})");
  must({"--video", "clip.mp4", "--depth", "depth.npz", "--fx", "64", "--no-resize", "--frames", "2", "--out", "out",
        "--eval-reference", "same.png", "--eval-cameras", "camera.json"});
  const auto methods = record("out")["stages"][4]["methods"];
  ASSERT_EQ(methods.size(), 4U);
  EXPECT_THAT(record("out")["stages"][1]["reliability"].get<std::string>(), ::testing::StartsWith("off: 0 %"));
  for (const auto& method : methods) {
    const bool equal = method["psnr"].is_null();  // infinite
    EXPECT_TRUE(equal || method["psnr"] > 60.0) << method.dump() << ": it is the source's own camera";
    EXPECT_GT(method["valid_share"], 0.5) << method.dump();
  }
  EXPECT_TRUE(fs::exists(folder_.file("out/reference_comparison.png")));
}

TEST_F(UwvApp, LookWritesNothing) {
  make_clip(folder_, {});
  const auto before = listing(folder_.path().string());
  EXPECT_THAT(must({"look", "--video", "clip.mp4", "--depth", "depth.npz", "--traj", "left"}).out,
              HasSubstr("parallax up to"));
  EXPECT_EQ(listing(folder_.path().string()), before);
}

TEST_F(UwvApp, CompareFindsEqualAndDifferentClips) {
  make_clip(folder_, {});
  must(run_arguments("out"));
  EXPECT_THAT(must({"compare", "--a", "clip.mp4", "--b", "clip.mp4"}).out, HasSubstr("equal frames 5"));
  EXPECT_THAT(must({"compare", "--a", "clip.mp4", "--b", "out/colour.mp4", "--mask", "out/generate_mask.mp4"}).out,
              HasSubstr("equal frames 0"));
  make_clip(folder_, {.frames = 4});
  EXPECT_EQ(app({"compare", "--a", "clip.mp4", "--b", "out/colour.mp4"}).exit_code, 2);
}

TEST_F(UwvApp, DoctorAndVersionAnswer) {
  const std::string doctor = must({"doctor"}).out;
  for (const char* word : {"libavcodec", "cpu", "auto takes", "H.264"}) EXPECT_THAT(doctor, HasSubstr(word));
  EXPECT_FALSE(must({"--version"}).out.empty());
}

TEST_F(UwvApp, WarningsAreSaidAndRecorded) {
  make_clip(folder_, {});
  const Outcome outcome =
      must({"--video", "clip.mp4", "--depth", "depth.npz", "--no-resize", "--traj", "swing1", "--out", "out"});
  for (const char* word : {"field of view", "product_in_view"}) {
    EXPECT_THAT(outcome.out, HasSubstr(word));
    EXPECT_THAT(record("out")["warnings"].dump(), HasSubstr(word));
  }
}

}  // namespace
}  // namespace uwv::test
