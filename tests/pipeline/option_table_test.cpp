// SPDX-License-Identifier: Apache-2.0
#include "uwv/pipeline/option_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "support/temp_folder.h"

namespace uwv {
namespace {

using testing::HasSubstr;

/// The sentence of the Error that `body` throws; fails the test when it throws none.
template <class Body>
std::string sentence_of(Body body) {
  try {
    body();
  } catch (const std::exception& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

RunOptions unusual() {
  RunOptions o;
  o.video = "in put.mp4";
  o.depth_scale = 0.001;
  o.fx = 994.978;
  o.cx = -0.25;
  o.pixel_centre = PixelCentre::integer;
  o.start = 3;
  o.size = {64, 48};
  o.frames = 7;
  o.renderer = RendererChoice::cpu;
  o.gl = GlBackend::osmesa;
  o.kernel = Kernel::bilinear;
  o.visibility = Visibility::ztest;
  o.accumulation = Accumulation::product_in_view;
  o.normal_filter = false;
  o.reliability = ReliabilityChoice::off;
  o.reliability_ratio = 0.1F;
  o.depth_format = DepthOutput::exr;
  o.ply = {0, 5, 80};
  o.complete = Completion::inpaint;
  o.save_masks = true;
  return o;
}

TEST(OptionTable, JsonRoundTripKeepsEverything) {
  const nlohmann::ordered_json written = to_json(unusual());
  const RunOptions read = options_from_json(nlohmann::json::parse(written.dump()), "test");
  EXPECT_EQ(to_json(read), written);
  EXPECT_EQ(read.fx, 994.978);
  EXPECT_EQ(read.fov, std::nullopt);
  EXPECT_EQ(read.ply, (std::vector<long>{0, 5, 80}));
  EXPECT_EQ(read.size, (Size{64, 48}));
}

TEST(OptionTable, TextRoundTripKeepsEverything) {
  RunOptions copy;
  for (const OptionInfo& info : option_table()) set_option(copy, info.name, option_text(unusual(), info.name));
  EXPECT_EQ(to_json(copy), to_json(unusual()));
}

TEST(OptionTable, EveryOptionIsDescribedOnceAndBelongsToAStage) {
  std::set<std::string> names;
  std::size_t in_scopes = 0;
  for (const OptionInfo& info : option_table()) {
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_GT(info.help.size(), 10U) << info.name;
    EXPECT_EQ(info.flag().find('_'), std::string::npos) << info.flag();
  }
  using enum OptionScope;
  for (const OptionScope scope : {nothing, clip, geometry, conditioning, completion, presentation, evaluation})
    in_scopes += to_json(RunOptions{}, scope).size();
  EXPECT_EQ(in_scopes, names.size());
}

TEST(OptionTable, FloatsAreWrittenShort) {
  EXPECT_EQ(to_json(RunOptions{})["reliability_ratio"].dump(), "0.1");
  EXPECT_EQ(option_text(RunOptions{}, "slope_discontinuity"), "0.1");
}

TEST(OptionTable, BadTextNamesFlagFoundAndWanted) {
  RunOptions o;
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{{"crf", "ten"},
                                                                                   {"crf", "10.5"},
                                                                                   {"crf", ""},
                                                                                   {"stride", "99999999999999999999"},
                                                                                   {"alpha", "nan"},
                                                                                   {"fps", "inf"},
                                                                                   {"size", "640"},
                                                                                   {"size", "640x"},
                                                                                   {"kernel", "fancy"},
                                                                                   {"ply", "1,x"},
                                                                                   {"normal_filter", "maybe"}}) {
    const std::string sentence = sentence_of([&] { set_option(o, name, text); });
    EXPECT_THAT(sentence, HasSubstr("--" + std::string(name == "normal_filter" ? "normal-filter" : name)));
    EXPECT_THAT(sentence, HasSubstr("'" + text + "'"));
    EXPECT_THAT(sentence, HasSubstr("wanted"));
  }
  EXPECT_THAT(sentence_of([&] { set_option(o, "kernel", "fancy"); }), HasSubstr("nearest, bilinear, resample"));
}

TEST(OptionTable, UnknownKeySuggestsTheNearest) {
  const auto json = nlohmann::json::parse(R"({"max_frame": 3})");
  EXPECT_THAT(sentence_of([&] { options_from_json(json, "run.json"); }), HasSubstr("'max_frames'"));
}

TEST(OptionTable, WrongJsonTypesAreRefused) {
  for (const char* text : {R"({"crf": "10"})", R"({"crf": 1.5})", R"({"video": 3})", R"({"overwrite": 1})",
                           R"({"ply": 3})", R"({"size": [64, 48]})", R"([])", R"({"point_size": 1e300})"})
    EXPECT_THROW(options_from_json(nlohmann::json::parse(text), "x"), Error) << text;
}

TEST(OptionTable, FlagsOfOlderRecordsAreUnderstood) {
  EXPECT_EQ(options_from_json(nlohmann::json::parse(R"({"layers": false})"), "x").layers, LayerChoice::off);
  EXPECT_EQ(options_from_json(nlohmann::json::parse(R"({"layers": true})"), "x").layers, LayerChoice::on);
  EXPECT_THROW(options_from_json(nlohmann::json::parse(R"({"cloud": true})"), "x"), Error);
}

TEST(OptionTable, ReadsARunRecordAndBareOptions) {
  const test::TempFolder folder;
  const std::string bare = to_json(unusual()).dump();
  const std::string record = nlohmann::ordered_json{{"program", "uwv_app"}, {"options", to_json(unusual())}}.dump();
  EXPECT_EQ(to_json(read_options(folder.write("bare.json", bare))), to_json(unusual()));
  EXPECT_EQ(to_json(read_options(folder.write("run.json", record))), to_json(unusual()));
  EXPECT_THROW(read_options(folder.file("none.json")), Error);
  EXPECT_THROW(read_options(folder.write("cut.json", bare.substr(0, bare.size() / 2))), Error);
}

RunOptions usable() {
  RunOptions o;
  o.video = "a.mp4";
  return o;
}

TEST(RunOptions, DefaultsAreUsableOnceAClipIsNamed) {
  EXPECT_NO_THROW(usable().check());
  EXPECT_THROW(RunOptions{}.check(), std::invalid_argument);
}

TEST(RunOptions, OutOfRangeValuesAreRefused) {
  const std::vector<std::pair<std::string, std::string>> bad = {{"stride", "0"},
                                                                {"start", "-1"},
                                                                {"max_frames", "-1"},
                                                                {"fov", "180"},
                                                                {"fov", "0"},
                                                                {"fx", "0"},
                                                                {"fy", "3"},
                                                                {"cx", "3"},
                                                                {"size", "0x5"},
                                                                {"size", "70000x5"},
                                                                {"max_side", "15"},
                                                                {"frames", "0"},
                                                                {"frames", "1000001"},
                                                                {"radius", "0"},
                                                                {"elevation", "91"},
                                                                {"alpha", "181"},
                                                                {"alpha", "-1"},
                                                                {"crf", "52"},
                                                                {"fps", "0"},
                                                                {"point_size", "0"},
                                                                {"threads", "-1"},
                                                                {"ply", "0,-1"},
                                                                {"contact_sheet", "-1"},
                                                                {"max_error", "-1"},
                                                                {"max_error", "1001"},
                                                                {"depth_scale", "0"},
                                                                {"disparity", "d.npy"},
                                                                {"reliability_window", "4"},
                                                                {"accumulation", "foreground"},
                                                                {"eval_reference", "r.png"},
                                                                {"traj", ""},
                                                                {"max_tilt", "91"},
                                                                {"max_footprint", "0"},
                                                                {"fringe", "-1"},
                                                                {"log_depth_max", "-1"},
                                                                {"return_size", "0"},
                                                                {"slope_radius", "0"},
                                                                {"depth_tolerance", "-1"}};
  for (const auto& [name, text] : bad) {
    RunOptions o = usable();
    set_option(o, name, text);
    EXPECT_THROW(o.check(), std::invalid_argument) << name << " " << text;
  }
}

TEST(RunOptions, ContradictionsAreRefused) {
  RunOptions both_depths = usable();
  both_depths.depth = "a", both_depths.disparity = "b", both_depths.baseline = 1;
  EXPECT_THROW(both_depths.check(), std::invalid_argument);
  RunOptions both_lenses = usable();
  both_lenses.fx = 500, both_lenses.fov = 60;
  EXPECT_THROW(both_lenses.check(), std::invalid_argument);
  RunOptions both_sizes = usable();
  both_sizes.size = {8, 8}, both_sizes.no_resize = true;
  EXPECT_THROW(both_sizes.check(), std::invalid_argument);
}

TEST(RunOptions, OutFolderFollowsTheClip) {
  const auto out_of = [](std::string video, std::string out = "") {
    RunOptions o;
    o.video = std::move(video);
    o.out = std::move(out);
    return o.out_folder();
  };
  EXPECT_EQ(out_of("dir/clip.mp4"), "clip_uwv");
  EXPECT_EQ(out_of("dir/frames/"), "frames_uwv");
  EXPECT_EQ(out_of("."), "clip_uwv");
  EXPECT_EQ(out_of("clip.mp4", "here"), "here");
}

TEST(RunOptions, IntrinsicsByNumber) {
  RunOptions o = usable();
  EXPECT_FALSE(intrinsics_by_number(o, {640, 480}).has_value());
  o.fx = 500;
  EXPECT_EQ(*intrinsics_by_number(o, {640, 480}), (Intrinsics{500, 500, 320, 240}));
  o.cx = 311.193;
  o.pixel_centre = PixelCentre::integer;
  EXPECT_DOUBLE_EQ(intrinsics_by_number(o, {640, 480})->cx, 311.693);
  EXPECT_EQ(intrinsics_by_number(o, {640, 480})->cy, 240);  // an unset centre is the picture's, in either counting
  o.fx.reset();
  o.fov = 90;
  EXPECT_NEAR(intrinsics_by_number(o, {640, 480})->fx, 320, 1e-9);
}

TEST(RunOptions, OcclusionOptionsCarryOver) {
  RunOptions o = unusual();
  o.alpha = 60;
  o.slope_radius = 2;
  const OcclusionOptions occlusion = occlusion_options(o);
  EXPECT_NEAR(occlusion.alpha, std::numbers::pi / 3, 1e-15);
  EXPECT_EQ(occlusion.kernel, Kernel::bilinear);
  EXPECT_EQ(occlusion.slopes.radius, 2);
  EXPECT_FALSE(occlusion.normal_filter);
  EXPECT_EQ(occlusion_options(RunOptions{}).alpha, std::numbers::pi / 2);  // exactly: the reference's threshold of 0
}

}  // namespace
}  // namespace uwv
