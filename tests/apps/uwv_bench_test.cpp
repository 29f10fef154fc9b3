// SPDX-License-Identifier: Apache-2.0
// uwv_bench as a process, on pictures small enough to be quick.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "apps/program.h"
#include "support/temp_folder.h"
#include "uwv/eval/path_truth.h"
#include "uwv/io/cameras_file.h"
#include "uwv/io/depth_file.h"
#include "uwv/io/image_file.h"

namespace uwv::test {
namespace {

namespace fs = std::filesystem;
using testing::Each;
using testing::Gt;
using testing::HasSubstr;

class UwvBench : public testing::Test {
 protected:
  Outcome bench(const std::vector<std::string>& arguments) const { return run_app(folder_.path().string(), arguments); }
  /// Runs and expects success.
  Outcome must(const std::vector<std::string>& arguments) const {
    Outcome outcome = bench(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err << outcome.out;
    return outcome;
  }
  nlohmann::json json(const std::string& name) const { return nlohmann::json::parse(folder_.read(name)); }

  /// A recording in the layout --rgbd reads: the ball scene from its own camera and then ever further to the side.
  void make_recording(const std::string& name, int frames = 2, double degrees = 15) const {
    constexpr Size size{160, 120};
    const fs::path root = folder_.file(name);
    for (const char* part : {"image", "depth", "test_scene"}) fs::create_directories(root / part);
    ThreadPool pool(2);
    StockScene scene = sphere_floor_wall({.size = size});
    scene.source.intrinsics = Intrinsics::from_integer_centres(525, 525, 319.5, 239.5).resized({640, 480}, size);
    CameraTrack track{{scene.source}, {}};
    for (const Camera& camera : orbit_path(scene, degrees * std::numbers::pi / 180, frames - 1))
      track.cameras.push_back(camera);
    for (int i = 0; i < frames; ++i) {
      track.times.push_back(i);
      const SyntheticFrame seen = render(scene.scene, track.cameras[static_cast<std::size_t>(i)], 0, pool, 2);
      write_png((root / fmt::format("image/{:05}.png", i)).string(), seen.colour);
      write_depth_file((root / fmt::format("depth/{:05}.png", i)).string(), seen.depth);
    }
    write_cameras((root / "test_scene/trajectory.log").string(), track, CamerasFormat::redwood);
  }

  TempFolder folder_;
};

TEST_F(UwvBench, MeasuresWhatMovesAndWhatItHides) {
  must({"moving", "--width", "208", "--height", "120", "--json", "moving.json"});
  const nlohmann::json tables = json("moving.json");
  EXPECT_GT(tables["moving pixels, 7 frames of 208x120"][0]["overlap"], 0.5);
  const nlohmann::json& background = tables["background of 21 frames of 208x120"];
  EXPECT_GT(background[0]["psnr"], 25);
  EXPECT_LT(background[0]["abs_rel"], 0.02);
  EXPECT_LE(background[1]["seen_%"], background[0]["seen_%"]);
}

TEST_F(UwvBench, SavesASceneThatReadsBack) {
  must({"scene", "--scene", "boxes_room", "--width", "64", "--height", "40", "--out", "room/of boxes"});
  EXPECT_EQ(read_image(folder_.file("room/of boxes/colour.png")).size(), (Size{64, 40}));
  EXPECT_THAT(read_depth_file(folder_.file("room/of boxes/depth.npy")).pixels(), Each(Gt(0)));
  Monitor monitor;
  const CameraTrack track = read_cameras(folder_.file("room/of boxes/cameras.json"), {}, monitor);
  EXPECT_EQ(track.cameras.at(0).size, (Size{64, 40}));
}

TEST_F(UwvBench, JudgesRealPairsByEveryMethod) {
  make_recording("recording");
  const std::string said = must({"real", "--rgbd", "recording", "--pairs", "0:1", "--motorcycle", "none", "--runs", "1",
                                 "--no-resize", "--json", "real.json"})
                               .out;
  EXPECT_THAT(said, HasSubstr("motorcycle left out"));
  std::map<std::string, nlohmann::json> rows;
  const nlohmann::json tables = json("real.json");
  for (const auto& row : tables["real second views"])
    if (row["reliability"] == "off") rows[row["method"].get<std::string>()] = row;
  for (const char* method : {"naive (nearest)", "official (bilinear)", "ours", "ours, ztest"})
    ASSERT_TRUE(rows.contains(method)) << method;
  // Textures whose finest wave is two of these pixels long; a wrong pose or lens gives less than 20 dB.
  EXPECT_GT(rows["ours"]["psnr_common"].get<double>(), 28);
  EXPECT_GT(rows["ours"]["psnr_common"].get<double>(), rows["naive (nearest)"]["psnr_common"].get<double>());
  EXPECT_LE(rows["ours"]["through_%"].get<double>(), rows["naive (nearest)"]["through_%"].get<double>());
  EXPECT_GT(rows["ours"]["valid"].get<double>(), 0.7);
}

TEST_F(UwvBench, TimesEveryPassAtEverySize) {
  must({"render", "--runs", "1", "--sizes", "64x48,33x17", "--no-gl", "--json", "speed.json"});
  const nlohmann::json tables = json("speed.json");
  for (const auto& [name, rows] : {std::pair("per source frame", 3U), std::pair("one pass", 3U),
                                   std::pair("Algorithm 1, a new source frame each time", 9U)}) {
    ASSERT_EQ(tables[name].size(), 2 * rows) << name;
    EXPECT_EQ(tables[name].front()["size"], "64x48");
    EXPECT_EQ(tables[name].back()["size"], "33x17");
  }
  EXPECT_THAT(bench({"render", "--sizes", "64"}).err, HasSubstr("found '64', wanted sizes such as 832x480"));
}

TEST_F(UwvBench, AlignsDepthWithEveryLossAndSmoothing) {
  must({"alignment", "--width", "128", "--height", "128", "--runs", "1", "--json", "alignment.json"});
  const nlohmann::json tables = json("alignment.json");
  ASSERT_EQ(tables["alignment of one frame"].size(), 27U);
  for (const auto& row : tables["alignment of one frame"])
    if (row["loss"] != "squared" && row["share"] == 1.0) {
      EXPECT_LT(row["error"].get<double>(), 0.02) << row;
    }
  EXPECT_EQ(tables["alignment of 120 flickering frames, an eighth as wide"].size(), 21U);
}

TEST_F(UwvBench, JudgesGeometryAndDrawsWhatItCosts) {
  make_recording("recording", 5, 10);
  const std::string said = must({"geometry", "--recording", "recording", "--no-resize", "--json", "geometry.json",
                                 "--plot", "front.svg", "--pairs", "0:1,0:10"})
                               .out;
  EXPECT_THAT(said, HasSubstr("COLMAP left out"));
  EXPECT_THAT(said, HasSubstr("views 0:10 left out: the clip has 5 frames"));
  EXPECT_THAT(folder_.read("front.svg"), HasSubstr("polyline"));
  const nlohmann::json tables = json("geometry.json");
  std::map<std::string, nlohmann::json> depth;
  for (const auto& row : tables["depth of recording"])
    if (row["cameras"] == "true") depth[row["option"].get<std::string>()] = row;
  for (const char* option : {"default", "key_stride=8", "scale=0.25", "planes=32", "neighbours=2", "complete=off"})
    EXPECT_TRUE(depth.contains(option)) << option;
  // Rounded to millimetres, seen by exact cameras.
  EXPECT_LT(depth["none: the truth itself"]["flicker"].get<double>(), 2e-3);
  EXPECT_EQ(depth["none: the truth itself"]["edge_f"], 1);
  // Textures whose finest wave is two pixels long leave the matcher little; wrong cameras would leave it nothing.
  EXPECT_LT(depth["default"]["abs_rel_measured"].get<double>(), 0.15);
  EXPECT_GT(depth["default"]["measured"].get<double>(), 0.3);
  EXPECT_LT(depth["complete=off"]["known"], depth["default"]["known"]);
  EXPECT_EQ(tables["cameras of recording"].size(), 2U);
  EXPECT_GT(tables["machine"].front()["processors"].get<int>(), 0);
}

TEST_F(UwvBench, LeavesOutWhatIsNotThereAndSaysSo) {
  const Outcome stereo = bench({"stereo", "--stereo", "nowhere"});
  EXPECT_EQ(stereo.exit_code, 2);
  EXPECT_THAT(stereo.out, HasSubstr("nowhere left out: it holds none of"));
  EXPECT_THAT(bench({"rendered", "--models", "none", "--cases", "sea"}).err, HasSubstr("found 'sea', wanted some of"));
  const Outcome rendered = bench({"rendered", "--models", "none"});
  EXPECT_EQ(rendered.exit_code, 2);
  EXPECT_THAT(rendered.err, HasSubstr("none/kaykit_dungeon_CC0/gltf/"));
  EXPECT_THAT(must({"alignment", "--width", "16", "--height", "16", "--runs", "1"}).out,
              HasSubstr("flicker of a real clip left out"));
}

TEST_F(UwvBench, SaysWhatIsWrongWithPairs) {
  make_recording("recording");
  for (const auto& [pair, words] : std::map<std::string, std::string>{
           {"0:7", "recording: has 2 frames, the pair wants number 7"}, {"3", "wanted two frames"}, {"1:1", "1:1"}}) {
    const Outcome outcome =
        bench({"real", "--rgbd", "recording", "--motorcycle", "none", "--runs", "1", "--pairs", pair});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, HasSubstr(words));
  }
  EXPECT_THAT(bench({"real", "--motorcycle", "none"}).err, HasSubstr("give --motorcycle or --rgbd"));
}

TEST_F(UwvBench, LeavingOutPassesChangesNoPixel) {
  must({"accuracy", "--width", "96", "--height", "56", "--steps", "2", "--runs", "1", "--json", "accuracy.json",
        "--plot", "options.svg"});
  EXPECT_THAT(folder_.read("options.svg"), HasSubstr("default"));
  const nlohmann::json tables = json("accuracy.json");
  for (const auto& row : tables["passes left out"]) {
    EXPECT_THAT(row["identical"].get<std::string>(), testing::StartsWith("yes")) << row;
    EXPECT_LE(row["passes"], row["passes_without_skipping"]);
  }
  for (const char* name : {"resolution", "width of depth", "long paths", "smeared depth, one frame to each angle"})
    EXPECT_FALSE(tables[name].empty()) << name;
}

TEST_F(UwvBench, SaysWhatIsWrongWithClips) {
  const Outcome clip = bench({"clip", "--models", "none", "--out", "hall"});
  EXPECT_EQ(clip.exit_code, 2);
  EXPECT_THAT(clip.err, HasSubstr("none/kaykit_dungeon_CC0/gltf/"));
  EXPECT_THAT(bench({"clip", "--models", "none", "--out", "hall", "--texture", "2"}).err,
              HasSubstr("texture 2 is outside 0..1"));
  const Outcome found = bench({"geometry", "--recording", "nowhere"});
  EXPECT_EQ(found.exit_code, 2);
  EXPECT_THAT(found.err, HasSubstr("nowhere: holds none of cameras.json"));
  EXPECT_THAT(bench({"geometry", "--recording", "nowhere", "--tables", "chairs"}).err, HasSubstr("found 'chairs'"));
}

}  // namespace
}  // namespace uwv::test
