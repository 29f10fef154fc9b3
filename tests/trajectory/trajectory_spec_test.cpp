// SPDX-License-Identifier: Apache-2.0
#include "uwv/trajectory/trajectory_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "support/temp_folder.h"
#include "uwv/trajectory/target_path.h"

namespace uwv {
namespace {

using testing::HasSubstr;

/// The error of a text, or "" when it is accepted.
std::string error_of(std::string_view json) {
  try {
    parse_trajectory(json, "t.json");
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// The fenced JSON blocks of the format's documentation.
std::vector<std::string> documented_examples() {
  std::ifstream stream(std::filesystem::path(UWV_TEST_DATA) / "../../docs/trajectories.md");
  std::vector<std::string> examples;
  bool inside = false;
  for (std::string line; std::getline(stream, line);) {
    if (line == "```json") {
      inside = true;
      examples.emplace_back();
    } else if (line == "```") {
      inside = false;
    } else if (inside) {
      examples.back() += line + "\n";
    }
  }
  return examples;
}

TEST(TrajectoryFile, documented_examples_parse_build_and_round_trip) {
  const auto examples = documented_examples();
  ASSERT_GE(examples.size(), 6U);
  for (const std::string& example : examples) {
    SCOPED_TRACE(example);
    const TrajectorySpec spec = parse_trajectory(example, "example");
    EXPECT_EQ(parse_trajectory(to_json(spec), "example"), spec) << to_json(spec);
    const Rigid3 still;
    const PathContext context =
        make_context(spec, Intrinsics::from_fov_x(1, {832, 480}), {832, 480}, {&still, 1}, 81, 2.5, false);
    EXPECT_EQ(std::ssize(build_path(spec, context).frames), path_frames(spec, context));
  }
}

TEST(TrajectoryFile, reads_every_key) {
  const TrajectorySpec spec = parse_trajectory(R"({
    "frames": 33, "fps": 23.976, "elevation": 4, "radius": 2.5, "radius_scale": 0.5, "units": "radius",
    "follow_source": true, "time": {"freeze": 7},
    "free": {"d_phi": 1, "d_theta": 2, "d_r": 3, "x": 4, "y": 5, "z": 6, "focal": 7, "easing": "in_out", "zoom_twice": true}
  })",
                                               "t.json");
  TrajectorySpec wanted;
  wanted.name = "t.json";
  wanted.frames = 33;
  wanted.fps = 23.976;
  wanted.elevation = 4;
  wanted.radius = 2.5;
  wanted.radius_scale = 0.5;
  wanted.units = LengthUnit::radius;
  wanted.follow_source = true;
  wanted.time = FreezeTime{7};
  wanted.motion = FreeMove{1, 2, 3, 4, 5, 6, 7, Easing::in_out, true};
  EXPECT_EQ(spec, wanted);
}

TEST(TrajectoryFile, orbit_is_a_full_circle_by_default) {
  EXPECT_EQ(std::get<FreeMove>(parse_trajectory(R"({"orbit": {}})", "t").motion).d_phi, -360);
  EXPECT_EQ(std::get<FreeMove>(parse_trajectory(R"({"orbit": {"d_phi": 90}})", "t").motion).d_phi, 90);
}

TEST(TrajectoryFile, round_trips_poses_to_the_last_bit) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.234, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  TrajectorySpec spec;
  spec.motion = KeyframeMotion{{
      {.at = 0.1, .place = Rigid3{turn, {1e7 / 3, -1e-7 / 3, 1}}, .roll = 3},
      {.at = 0.2, .place = Eigen::Vector3d(1, 2, 3), .aim = turn, .fov = 170},
      {.at = 0.3, .place = SpherePlace{1, 2, 3}, .aim = SubjectPoint{}, .easing = Easing::out},
      {.at = 0.4, .place = SpherePlace{4, 5, 6}, .aim = Eigen::Vector3d(0.1, 0.2, 0.3), .focal = 1.0 / 3},
  }};
  EXPECT_EQ(parse_trajectory(to_json(spec), spec.name), spec) << to_json(spec);
  spec.motion =
      CameraMotion{{{Rigid3{turn, {1, 2, 3}}, Intrinsics{1, 2, 3, 4}, {}, Size{5, 6}}, {Rigid3{}, {}, 90.0, {}}}, ""};
  EXPECT_EQ(parse_trajectory(to_json(spec), spec.name), spec) << to_json(spec);
  spec.motion = CameraMotion{{}, "cameras.json"};
  EXPECT_EQ(parse_trajectory(to_json(spec), spec.name), spec) << to_json(spec);
}

struct BadFile {
  const char* json;
  const char* pointer;
  const char* hint;
};

TEST(TrajectoryFile, says_where_and_what_is_wrong) {
  const std::vector<BadFile> files{
      {"[]", "t.json", "an object"},
      {"{}", "t.json", "one of the keys preset"},
      {R"({"preset": "lefft"})", "/preset", "did you mean 'left'?"},
      {R"({"preset": {"name": "left", "zoom": 2}})", "/preset/zoom", "focal"},
      {R"({"presset": "left"})", "/presset", "did you mean 'preset'?"},
      {R"({"preset": "left", "free": {}})", "t.json", "both 'preset' and 'free'"},
      {R"({"preset": "left", "frames": 0})", "/frames is 0", "1 to 1000000"},
      {R"({"preset": "left", "frames": -5})", "/frames is -5", "1 to 1000000"},
      {R"({"preset": "left", "frames": 1000001})", "/frames", "1 to 1000000"},
      {R"({"preset": "left", "frames": 1e300})", "/frames", "1 to 1000000"},
      {R"({"preset": "left", "frames": 2.5})", "/frames is 2.5", "whole number"},
      {R"({"preset": "left", "frames": 18446744073709551615})", "/frames", "whole number"},
      {R"({"preset": "left", "fps": 0})", "/fps is 0", "(0, 1000]"},
      {R"({"preset": "left", "elevation": 90})", "/elevation", "(-90, 90)"},
      {R"({"preset": "left", "radius": "big"})", "/radius", "\"auto\""},
      {R"({"preset": "left", "radius": 0})", "/radius is 0", "[1e-09"},
      {R"({"preset": "left", "units": "metres"})", "/units", "scene, radius"},
      {R"({"preset": "left", "frame_of_reference": "source_world"})", "/frame_of_reference", "keyframes or cameras"},
      {R"({"preset": "left", "follow_source": 1})", "/follow_source is 1", "true or false"},
      {R"({"free": {"d_r": 0}})", "/free/d_r is 0", "(0, "},
      {R"({"free": {"d_phi": "left"}})", "/free/d_phi is \"left\"", "a number"},
      {R"({"free": {"easing": "smoth"}})", "/free/easing", "did you mean 'smooth'?"},
      {R"({"free": {"focal": -1}})", "/free/focal", "a number in"},
      {R"({"free": null})", "/free is null", "an object"},
      {R"({"txt": {"phi": []}})", "/txt/phi", "1 to 1000 numbers"},
      {R"({"txt": {"r": [0, -1]}})", "/txt/r/1 is -1", "[-0.999"},
      {R"({"keyframes": []})", "/keyframes", "1 to 100000 keyframes"},
      {R"({"keyframes": [{"at": 2}]})", "/keyframes/0/at is 2", "[0, 1]"},
      {R"({"keyframes": [{"at": 0.5}, {"at": 0.5}]})", "/keyframes/1/at", "after the previous keyframe's 0.5"},
      {R"({"keyframes": [{"frame": 3}, {"frame": 1}]})", "/keyframes/1/frame", "after the previous"},
      {R"({"keyframes": [{"at": 0}, {}]})", "/keyframes/1", "in all keyframes or in none"},
      {R"({"keyframes": [{"at": 0, "frame": 0}]})", "/keyframes/0", "both 'at' and 'frame'"},
      {R"({"keyframes": [{"position": [1, 2]}]})", "/keyframes/0/position is an array of 2", "3 numbers"},
      {R"({"keyframes": [{"position": [1, 2, null]}]})", "/keyframes/0/position/2 is null", "a number"},
      {R"({"keyframes": [{"position": [1, 2, 1e300]}]})", "/keyframes/0/position/2", "a number in"},
      {R"({"keyframes": [{"position": [1, 2, 3], "phi": 3}]})", "/keyframes/0/phi", "does not go with position"},
      {R"({"keyframes": [{"lookat": "subject"}]})", "/keyframes/0/lookat", "did you mean 'look_at'?"},
      {R"({"keyframes": [{"look_at": "me"}]})", "/keyframes/0/look_at", "\"subject\" or a point"},
      {R"({"keyframes": [{"fov": 180}]})", "/keyframes/0/fov is 180", "(0, 180)"},
      {R"({"keyframes": [{"fov": 60, "focal": 2}]})", "/keyframes/0", "both 'focal' and 'fov'"},
      {R"({"keyframes": [{"rotation": [1, 1, 0, 0]}]})", "/keyframes/0/rotation", "quaternion"},
      {R"({"keyframes": [{"rotation": [2,0,0, 0,1,0, 0,0,1]}]})", "/keyframes/0/rotation", "orthonormal"},
      {R"({"keyframes": [{"world_from_cam": [1,0,0,0, 0,1,0,0, 0,0,-1,0, 0,0,0,1]}]})", "/keyframes/0/world_from_cam",
       "mirrors"},
      {R"({"keyframes": [{"world_from_cam": [[1,0,0,0],[0,1,0,0],[0,0,1],[0,0,0,1]]}]})",
       "/keyframes/0/world_from_cam/2", "4 numbers"},
      {R"({"keyframes": [{"world_from_cam": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1], "look_at": "subject"}]})",
       "/keyframes/0/look_at", "does not go with world_from_cam"},
      {R"({"cameras": [{}]})", "/cameras/0", "'world_from_cam' is missing"},
      {R"({"cameras": [{"world_from_cam": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1], "fx": 3}]})", "/cameras/0",
       "'fy' is missing"},
      {R"({"cameras": [{"world_from_cam": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}], "frames": 3})", "/cameras",
       "/frames is 3"},
      {R"({"cameras": 7})", "/cameras is 7", "or a file"},
      {R"({"cameras": ""})", "/cameras", "the path of a cameras file"},
      {R"({"preset": "left", "time": "stop"})", "/time is \"stop\"", "\"follow\""},
      {R"({"preset": "left", "time": {"freeze": -1}})", "/time/freeze is -1", "whole number"},
      {R"({"preset": "left", "time": {"from": 1}})", "/time", "the pair"},
      {R"({"preset": "left", "time": {}})", "/time", "'freeze'"},
      {R"({"preset": "left", "time": {"frames": [0, 1]}, "frames": 3})", "/time/frames", "/frames is 3"},
  };
  for (const BadFile& file : files) {
    const std::string error = error_of(file.json);
    EXPECT_THAT(error, HasSubstr("t.json")) << file.json;
    EXPECT_THAT(error, HasSubstr(file.pointer)) << file.json;
    EXPECT_THAT(error, HasSubstr(file.hint)) << file.json;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
}

TEST(TrajectoryFile, syntax_errors_name_line_and_column) {
  const std::string error = error_of("{\n  \"preset\": \"left\",\n  \"frames\": NaN\n}");
  EXPECT_THAT(error, HasSubstr("line 3"));
  EXPECT_THAT(error, HasSubstr("column"));
  EXPECT_NE(error_of(""), "");
  EXPECT_NE(error_of("{\"preset\": \"le"), "");
  EXPECT_NE(error_of(std::string(100'000, '[')), "");
  EXPECT_THAT(error_of(R"({"preset": "left", "preset": "right"})"), HasSubstr("twice"));
  EXPECT_NE(error_of("{\"preset\": \"\xff\xfe\"}"), "");
  EXPECT_NE(error_of(R"({"preset": "left", "frames": 1e999})"), "");
}

// Every prefix of a valid file, and every file with one byte changed, is accepted or refused, but never crashes.
TEST(TrajectoryFile, survives_damage) {
  for (const std::string& example : documented_examples()) {
    for (std::size_t i = 0; i < example.size(); ++i) {
      error_of(std::string_view(example).substr(0, i));
      std::string changed = example;
      for (const char c : {'\0', '"', '9', '-', '}', '\xff'}) {
        changed[i] = c;
        error_of(changed);
      }
    }
  }
}

TEST(TrajectoryFile, is_read_from_disk_with_relative_files) {
  const test::TempFolder folder;
  const auto write = [&](const char* name, const std::string& text) { std::ofstream(folder.path() / name) << text; };
  write("wave.txt", "0 30\n0. -1 +2\r\n0 -.3");
  write("t.json", R"({"txt": "wave.txt"})");
  write("c.json", R"({"cameras": "sub/cams.json"})");
  const OrbitLists wanted{{0, 30}, {0, -1, 2}, {0, -0.3}};
  EXPECT_EQ(std::get<OrbitLists>(read_trajectory(folder.path() / "t.json").motion), wanted);
  EXPECT_EQ(std::get<OrbitLists>(read_trajectory(folder.path() / "wave.txt").motion), wanted);
  EXPECT_EQ(std::get<CameraMotion>(read_trajectory(folder.path() / "c.json").motion).cameras_file,
            (folder.path() / "sub/cams.json").string());
  EXPECT_THROW(read_trajectory(folder.path() / "none.json"), Error);
  EXPECT_THROW(read_trajectory(folder.path()), Error);
  write("lost.json", R"({"txt": "none.txt"})");
  EXPECT_THROW(read_trajectory(folder.path() / "lost.json"), Error);
}

TEST(TrajectoryText, refuses_what_is_not_three_lines_of_numbers) {
  const auto error_of_text = [](std::string_view text) -> std::string {
    try {
      parse_orbit_lists(text, "w.txt");
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(error_of_text("0 1\n\n0\n0 .5\n\n"), "");
  EXPECT_THAT(error_of_text("0 1\n0 2"), HasSubstr("2 lines"));
  EXPECT_THAT(error_of_text("0\n0\n0\n0"), HasSubstr("fourth line"));
  EXPECT_THAT(error_of_text("0\n0 1x\n0"), HasSubstr("line 2, value 2 is '1x'"));
  EXPECT_THAT(error_of_text("0\n0 nan\n0"), HasSubstr("line 2, value 2"));
  EXPECT_THAT(error_of_text("0\n0 1e999\n0"), HasSubstr("line 2, value 2"));
  EXPECT_THAT(error_of_text("0\n0\n0 -1"), HasSubstr("line 3, value 2"));
  EXPECT_THAT(error_of_text("0 +\n0\n0"), HasSubstr("line 1, value 2"));
  std::string many;
  for (int i = 0; i < 1001; ++i) many += "1 ";
  EXPECT_THAT(error_of_text(many), HasSubstr("more than 1000"));
}

TEST(TrajectoryPreset, is_a_spec) {
  EXPECT_EQ(trajectory_from_preset("orbit").motion, Motion(PresetMotion{"orbit", 1}));
  try {
    trajectory_from_preset("orbitt");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("did you mean 'orbit'?"));
  }
}

}  // namespace
}  // namespace uwv
