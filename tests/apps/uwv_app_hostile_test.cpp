// SPDX-License-Identifier: Apache-2.0
// Bad input of every kind: exit code 2, one line on stderr, nothing left behind, nothing overwritten.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "apps/clip_maker.h"
#include "apps/program.h"
#include "uwv/io/image_file.h"
#include "uwv/io/npy.h"

namespace uwv::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

struct HostileCase {
  std::string name;
  std::vector<std::string> arguments;  ///< Behind those of a good run, which they override.
  std::string expected;                ///< Part of the sentence.
  std::function<void(const TempFolder&)> prepare = [](const TempFolder&) {};
};

std::ostream& operator<<(std::ostream& stream, const HostileCase& hostile) { return stream << hostile.name; }

std::string cameras_json(const std::string& matrix) {
  std::string frames;
  for (int i = 0; i < 5; ++i)
    frames += std::string(i > 0 ? "," : "") + R"({"index": )" + std::to_string(i) +
              R"(, "time": 0, "fx": 60, "fy": 60, "cx": 32, "cy": 24, "world_from_cam": )" + matrix + "}";
  return R"({"uwv_cameras": 1, "convention": "opencv, world_from_cam, pixel centres at +0.5", "width": 64,
             "height": 48, "frames": [)" +
         frames + "]}";
}

/// A valid .npy preamble with any header text.
std::string npy(std::string header) {
  header.resize((header.size() / 64 + 1) * 64 + 54 - 1, ' ');
  header += '\n';
  return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(header.size() & 0xFF) +
         static_cast<char>(header.size() >> 8) + header;
}

std::function<void(const TempFolder&)> put(const std::string& name, const std::string& bytes) {
  return [=](const TempFolder& folder) { folder.write(name, bytes); };
}

std::function<void(const TempFolder&)> put_depth(std::vector<std::size_t> shape) {
  return [=](const TempFolder& folder) {
    std::size_t values = 1;
    for (const std::size_t side : shape) values *= side;
    write_npy<float>(folder.file("bad.npy"), shape, std::vector<float>(values, 2.0F));
  };
}

const std::vector<std::string> bad_video = {"--video", "bad.mp4"}, bad_depth = {"--depth", "bad.npy"},
                               bad_cameras = {"--cameras", "bad.json"}, bad_path = {"--traj", "bad.json"};

const HostileCase cases[] = {
    {"missing_video", {"--video", "none.mp4"}, "none.mp4"},
    {"zero_byte_video", bad_video, "bad.mp4", put("bad.mp4", "")},
    {"text_called_mp4", bad_video, "bad.mp4", put("bad.mp4", "this is no video\nat all\n")},
    {"noise_called_mp4", bad_video, "bad.mp4", put("bad.mp4", std::string(5000, '\x5a'))},
    {"header_without_frames", bad_video, "bad.mp4",
     [](const TempFolder& folder) { folder.write("bad.mp4", folder.read("clip.mp4").substr(0, 200)); }},
    {"empty_folder",
     {"--video", "empty"},
     "empty",
     [](const TempFolder& folder) { fs::create_directory(folder.file("empty")); }},
    {"start_behind_the_end", {"--start", "100"}, "100"},
    {"depth_that_cannot_be_measured", {"--depth", "", "--geometry", "sfm"}, "cannot be measured"},
    {"import_of_nothing", {"--depth", "", "--geometry", "import"}, "--geometry import needs --depth"},
    {"estimation_of_what_is_given", {"--geometry", "prior"}, "leave --depth and --disparity out"},
    {"cameras_without_their_depth", {"--depth", "", "--cameras", "bad.json"}, "--cameras needs the depth"},
    {"missing_depth", {"--depth", "none.npz"}, "none.npz"},
    {"zero_byte_depth", bad_depth, "bad.npy", put("bad.npy", "")},
    {"too_few_depths", bad_depth, "found depth for 3 frames, wanted 5", put_depth({3, 48, 64})},
    {"depth_of_wrong_shape", bad_depth, "bad.npy", put_depth({5, 2, 48, 64})},
    {"depth_of_colour_shape", bad_depth, "bad.npy", put_depth({5, 48, 64, 3})},
    {"lying_npy_shape", bad_depth, "bad.npy",
     put("bad.npy", npy("{'descr': '<f4', 'fortran_order': False, 'shape': (1000000000000, 48, 64), }"))},
    {"overflowing_npy_shape", bad_depth, "bad.npy",
     put("bad.npy", npy("{'descr': '<f4', 'fortran_order': False, 'shape': (4294967296, 4294967296, 4), }"))},
    {"negative_npy_shape", bad_depth, "bad.npy",
     put("bad.npy", npy("{'descr': '<f4', 'fortran_order': False, 'shape': (-5, 48, 64), }"))},
    {"object_npy", bad_depth, "bad.npy",
     put("bad.npy", npy("{'descr': '|O', 'fortran_order': False, 'shape': (5, 48, 64), }"))},
    {"npy_header_longer_than_file", bad_depth, "bad.npy",
     put("bad.npy", std::string("\x93NUMPY\x01\x00\xff\xff{", 11))},
    {"truncated_npz",
     {"--depth", "bad.npz"},
     "bad.npz",
     [](const TempFolder& folder) { folder.write("bad.npz", folder.read("depth.npz").substr(0, 20000)); }},
    {"missing_npz_key", {"--depth-key", "nope"}, "nope"},
    {"depth_without_a_valid_pixel", bad_depth, "depth",
     [](const TempFolder& folder) {
       write_npy<float>(folder.file("bad.npy"), {5, 48, 64}, std::vector<float>(5 * 48 * 64, 0.0F));
     }},
    {"sheared_pose", bad_cameras, "bad.json", put("bad.json", cameras_json("[1,0.5,0,0,0,1,0,0,0,0,1,0,0,0,0,1]"))},
    {"singular_pose", bad_cameras, "bad.json", put("bad.json", cameras_json("[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,1]"))},
    {"mirrored_pose", bad_cameras, "bad.json", put("bad.json", cameras_json("[-1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]"))},
    {"pose_of_15_numbers", bad_cameras, "bad.json", put("bad.json", cameras_json("[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0]"))},
    {"cameras_without_frames", bad_cameras, "bad.json", put("bad.json", R"({"uwv_cameras": 1, "width": 64})")},
    {"cameras_are_no_json", bad_cameras, "bad.json", put("bad.json", "{\"uwv_cameras\": 1, ")},
    {"too_few_cameras", {"--cameras", "bad.txt"}, "bad.txt", put("bad.txt", "0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n")},
    {"missing_trajectory", {"--traj", "none.json"}, "none.json"},
    {"unknown_preset", {"--traj", "lefft"}, "left"},
    {"trajectory_is_no_json", bad_path, "bad.json", put("bad.json", "{ frames: 3 }")},
    {"trajectory_with_unknown_key", bad_path, "framess", put("bad.json", R"({"framess": 3, "preset": "left"})")},
    {"trajectory_freezes_behind_the_end", bad_path, "bad.json",
     put("bad.json", R"({"frames": 3, "preset": "left", "time": {"freeze": 99}})")},
    {"missing_foreground", {"--foreground", "none.mp4"}, "none.mp4"},
    {"normals_of_wrong_shape", {"--normals", "bad.npy"}, "normals", put_depth({5, 48, 64})},
    {"point_cloud_of_a_missing_frame", {"--ply", "5"}, "--ply"},
    {"unknown_option", {"--no-such-option"}, "--no-such-option"},
    {"number_that_is_none", {"--crf", "ten"}, "--crf"},
    {"number_out_of_range", {"--crf", "99"}, "--crf"},
    {"unknown_kernel", {"--kernel", "fancy"}, "nearest"},
    {"missing_options_file", {"--options", "none.json"}, "none.json"},
    {"output_is_a_file", {"--out", "clip.mp4"}, "clip.mp4"},
    {"output_is_the_input_folder",
     {"--video", "pictures", "--out", "pictures"},
     "pictures",
     [](const TempFolder& folder) {
       fs::create_directory(folder.file("pictures"));
       for (long i = 0; i < 5; ++i)
         write_png(folder.file("pictures/" + std::to_string(i) + ".png"), clip_picture({}, i));
     }},
    {"output_over_an_input",
     {"--video", "mine/colour.mp4", "--out", "mine"},
     "mine/colour.mp4",
     [](const TempFolder& folder) {
       fs::create_directory(folder.file("mine"));
       fs::copy_file(folder.file("clip.mp4"), folder.file("mine/colour.mp4"));
     }},
    {"output_over_a_foreign_file",
     {"--out", "mine"},
     "--overwrite",
     [](const TempFolder& folder) {
       fs::create_directory(folder.file("mine"));
       folder.write("mine/depth.npz", "precious");
     }},
};

class HostileInput : public testing::TestWithParam<HostileCase> {};

TEST_P(HostileInput, IsRefusedInOneLineAndLeavesNothing) {
  const TempFolder folder;
  make_clip(folder, {});
  GetParam().prepare(folder);
  const auto before = listing(folder.path().string());
  // CLI options take their last value only once, so a good argument is dropped where the case brings its own.
  std::vector<std::string> arguments = GetParam().arguments;
  const std::vector<std::string> good = run_arguments("out");
  for (std::size_t i = 0; i < good.size(); ++i) {
    const bool is_switch = good[i] == "--no-resize";
    const bool replaced = std::find(arguments.begin(), arguments.end(), good[i]) != arguments.end();
    if (!replaced) arguments.push_back(good[i]);
    if (!is_switch && !replaced) arguments.push_back(good[i + 1]);
    if (!is_switch) ++i;
  }
  const Outcome outcome = run_app(folder.path().string(), arguments);
  EXPECT_EQ(outcome.exit_code, 2) << outcome.out << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(GetParam().expected));
  EXPECT_EQ(listing(folder.path().string()), before);
}

INSTANTIATE_TEST_SUITE_P(UwvApp, HostileInput, testing::ValuesIn(cases),
                         [](const auto& tested) { return tested.param.name; });

TEST(HostileInput, TruncatedVideoGivesItsReadableFramesAndAWarning) {
  const TempFolder folder;
  make_clip(folder, {.size = {160, 120}, .frames = 60});
  const std::string whole = folder.read("clip.mp4");
  folder.write("clip.mp4", std::string_view(whole).substr(0, whole.size() * 2 / 3));
  const Outcome outcome = run_app(folder.path().string(), run_arguments("out", {"--max-frames", "0"}));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("warning"));
  EXPECT_TRUE(fs::exists(folder.file("out/colour.mp4")));
}

TEST(HostileInput, OverwriteReplacesAForeignFileWhenTold) {
  const TempFolder folder;
  make_clip(folder, {});
  fs::create_directory(folder.file("mine"));
  folder.write("mine/depth.npz", "precious");
  folder.write("mine/other.txt", "kept");
  EXPECT_EQ(run_app(folder.path().string(), run_arguments("mine", {"--overwrite"})).exit_code, 0);
  EXPECT_EQ(folder.read("mine/other.txt"), "kept");
}

}  // namespace
}  // namespace uwv::test
