// SPDX-License-Identifier: Apache-2.0
#include "uwv/geometry/saliency.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "uwv/core/thread_pool.h"
#include "uwv/eval/stock_scenes.h"

namespace uwv {
namespace {

/// A red, shaded ball before a plain, grey wall.
ImageRgb ball_picture(Size size, ForegroundMask& truth) {
  ImageRgb picture(size);
  truth = ForegroundMask(size);
  const double radius = 0.25 * size.height;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const double r = std::hypot(x - 0.5 * size.width, y - 0.55 * size.height) / radius;
      const auto grey = static_cast<std::uint8_t>(120 + 20 * y / size.height + (x * 7 + y * 13) % 5);
      const auto red = static_cast<std::uint8_t>(220 - 60 * std::min(r, 1.0));
      picture(x, y) = r < 1 ? Rgb8{red, 40, 30} : Rgb8{grey, grey, grey};
      truth(x, y) = r < 1;
    }
  return picture;
}

double overlap(const ForegroundMask& a, const ForegroundMask& b) {
  double both = 0, either = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    both += a.data()[i] != 0 && b.data()[i] != 0;
    either += a.data()[i] != 0 || b.data()[i] != 0;
  }
  return either > 0 ? both / either : 1;
}

void expect_probabilities(const Image<float>& p, Size size) {
  EXPECT_EQ(p.size(), size);
  EXPECT_TRUE(std::all_of(p.pixels().begin(), p.pixels().end(), [](float v) { return v >= 0 && v <= 1; }));
}

TEST(ContrastFinder, FindsABallBeforeAWall) {
  ForegroundMask truth;
  const ImageRgb picture = ball_picture({416, 240}, truth);
  const auto finder = make_contrast_finder();
  const Foreground found = find_foreground(picture, *finder);
  EXPECT_GT(overlap(found.mask, truth), 0.93) << found.note;
  EXPECT_EQ(finder->find(picture), finder->find(picture)) << "not deterministic";
}

TEST(ContrastFinder, FindsNothingInPlainPictures) {
  const auto finder = make_contrast_finder();
  EXPECT_EQ(find_foreground(ImageRgb({200, 100}, Rgb8{90, 120, 30}), *finder).mask.count(), 0U);
}

TEST(ContrastFinder, TakesTinyAndThinPictures) {
  const auto finder = make_contrast_finder();
  for (const Size size : {Size{1, 1}, Size{2, 3}, Size{500, 1}, Size{1, 500}, Size{17, 900}})
    expect_probabilities(finder->find(ImageRgb(size, Rgb8{1, 2, 3})), size);
  EXPECT_THROW(finder->find(ImageRgb()), std::invalid_argument);
}

ErrorCode code_of(const std::string& path) {
  try {
    make_saliency_network(path);
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error.code();
  }
  ADD_FAILURE() << path << " was taken";
  return ErrorCode::cancelled;
}

class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& name)
      : path_(std::filesystem::temp_directory_path() /
              (name + std::to_string(::testing::UnitTest::GetInstance()->random_seed()))) {}
  ~TemporaryFile() { std::filesystem::remove(path_); }
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

TEST(SaliencyNetwork, RefusesWhatIsNotThere) { EXPECT_EQ(code_of("/nowhere/u2netp.onnx"), ErrorCode::file_not_found); }

TEST(SaliencyNetwork, RefusesDamagedFiles) {
  const TemporaryFile file("uwv_damaged.onnx");
  std::ofstream(file.path(), std::ios::binary) << "this is no network at all, whatever its name says";
  EXPECT_EQ(code_of(file.path()), ErrorCode::file_damaged);
}

/// Bytes of an ONNX model with one Relu of another shape; field numbers are those of onnx.proto.
std::string relu_network() {
  const auto field = [](int number, const std::string& bytes) {
    return std::string{static_cast<char>(number << 3 | 2), static_cast<char>(bytes.size())} + bytes;
  };
  const auto integer = [](int number, int value) {
    return std::string{static_cast<char>(number << 3), static_cast<char>(value)};
  };
  const std::string shape = field(1, integer(1, 1)) + field(1, integer(1, 4));
  const auto tensor = [&](const std::string& name) {
    return field(1, name) + field(2, field(1, integer(1, 1) + field(2, shape)));
  };
  const std::string node = field(1, "x") + field(2, "y") + field(3, "n") + field(4, "Relu");
  const std::string graph = field(1, node) + field(2, "g") + field(11, tensor("x")) + field(12, tensor("y"));
  return integer(1, 7) + field(7, graph) + field(8, integer(2, 13));
}

TEST(SaliencyNetwork, RefusesAnotherNetwork) {
  const TemporaryFile file("uwv_relu.onnx");
  std::ofstream(file.path(), std::ios::binary) << relu_network();
  EXPECT_EQ(code_of(file.path()), ErrorCode::format_unknown);
}

TEST(SaliencyNetwork, FindsABall) {
  const std::string path = std::string(UWV_MODELS) + "/u2netp.onnx";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; scripts/setup fetches it";
  const auto network = make_saliency_network(path);
  ForegroundMask truth;
  const ImageRgb picture = ball_picture({416, 240}, truth);
  const Image<float> probability = network->find(picture);
  expect_probabilities(probability, picture.size());
  EXPECT_GT(overlap(foreground_from(probability, "u2netp").mask, truth), 0.9);
  expect_probabilities(network->find(ImageRgb(1, 1)), {1, 1});
}

TEST(SaliencyNetwork, RefusesATruncatedOne) {
  const std::string path = std::string(UWV_MODELS) + "/u2netp.onnx";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; scripts/setup fetches it";
  const TemporaryFile file("uwv_truncated.onnx");
  std::filesystem::copy_file(path, file.path(), std::filesystem::copy_options::overwrite_existing);
  std::filesystem::resize_file(file.path(), std::filesystem::file_size(path) / 2);
  EXPECT_EQ(code_of(file.path()), ErrorCode::file_damaged);
}

}  // namespace
}  // namespace uwv
