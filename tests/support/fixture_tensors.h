// SPDX-License-Identifier: Apache-2.0
// Golden tensors as our types, and the official renderer's batch rule.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "uwv/io/safetensors.h"
#include "uwv/render/occlusion.h"

namespace uwv::testing {

/// Files of a fixture folder whose names start and end as asked, sorted; failing loudly is the caller's job.
inline std::vector<std::filesystem::path> fixture_files(const std::filesystem::path& folder, const std::string& prefix,
                                                        const std::string& suffix = ".safetensors") {
  std::vector<std::filesystem::path> files;
  if (!std::filesystem::is_directory(folder)) return files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(prefix) && name.ends_with(suffix)) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// One tensor's values with the shape at hand. Leading dimensions are counted by `items`.
class Golden {
 public:
  Golden(const SafeTensors& file, const std::string& name) : shape_(file.info(name).shape) {
    values_ = file.as_float(name);
  }
  const std::vector<std::size_t>& shape() const { return shape_; }
  std::size_t dimension(int from_end) const { return shape_.at(shape_.size() - static_cast<std::size_t>(from_end)); }
  float at(std::size_t i) const { return values_.at(i); }

  /// Item `i` of [..., h, w] with any leading dimensions of which the first counts items.
  template <class Picture>
  Picture picture(std::size_t i = 0) const {
    const int w = static_cast<int>(dimension(1)), h = static_cast<int>(dimension(2));
    Picture out(w, h);
    for (std::size_t p = 0; p < out.size().pixels(); ++p)
      out.data()[p] =
          static_cast<std::remove_reference_t<decltype(*out.data())>>(values_.at(i * out.size().pixels() + p));
    return out;
  }
  /// Item `i` of [..., h, w, 3].
  template <class Pixel>
  Image<Pixel> interleaved(std::size_t i = 0) const {
    const int w = static_cast<int>(dimension(2)), h = static_cast<int>(dimension(3));
    Image<Pixel> out(w, h);
    for (std::size_t p = 0; p < out.size().pixels(); ++p) {
      const std::size_t v = 3 * (i * out.size().pixels() + p);
      out.data()[p] = Pixel{values_.at(v), values_.at(v + 1), values_.at(v + 2)};
    }
    return out;
  }
  /// Matrix `i` of [..., rows, cols].
  Eigen::MatrixXd matrix(std::size_t i = 0) const {
    const auto rows = static_cast<Eigen::Index>(dimension(2)), cols = static_cast<Eigen::Index>(dimension(1));
    Eigen::MatrixXd m(rows, cols);
    for (Eigen::Index r = 0; r < rows; ++r)
      for (Eigen::Index c = 0; c < cols; ++c)
        m(r, c) = values_.at(i * static_cast<std::size_t>(rows * cols) + static_cast<std::size_t>(r * cols + c));
    return m;
  }

 private:
  std::vector<std::size_t> shape_;
  std::vector<float> values_;
};

/// A camera from the reference's 3x3 K (integer pixel centres) and 4x4 c2w, as the reference unprojects with it.
inline Camera reference_camera(const Eigen::MatrixXd& k, const Eigen::MatrixXd& c2w, Size size) {
  return {Intrinsics::from_integer_centres(k(0, 0), k(1, 1), k(0, 2), k(1, 2)),
          Rigid3::from_matrix(c2w, "fixture", 1e-3), size};
}

/// The reference's normal filter on given world normals: n . (C - p) > 0.
inline ValidityMask official_front(const Image<Eigen::Vector3f>& normals_world, const PointGrid& points,
                                   const Camera& target) {
  ValidityMask front(normals_world.size());
  for (int y = 0; y < front.height(); ++y)
    for (int x = 0; x < front.width(); ++x) {
      const Eigen::Vector3d p =
          points.camera.world_from_cam * unproject(points.camera.intrinsics, {x + 0.5, y + 0.5}, (*points.depth)(x, y));
      front(x, y) = normals_world(x, y).cast<double>().dot(target.world_from_cam.translation - p) > 0;
    }
  return front;
}

/// L_max over one grid seen from one camera, dropped points included.
inline float log_depth_max(const PointGrid& points, const Camera& target) {
  const Rigid3 motion = target_from_source(target, points.camera);
  double farthest = 0;
  for (int y = 0; y < points.depth->height(); ++y)
    for (int x = 0; x < points.depth->width(); ++x) {
      const float z = (*points.depth)(x, y);
      if (z > 0)
        farthest = std::max(farthest, (motion * unproject(points.camera.intrinsics, {x + 0.5, y + 0.5}, z)).z());
    }
  return static_cast<float>(std::log1p(std::min(farthest, 1000.0)));
}

/// Official pictures hold -1 in holes.
inline RgbF hole_colour() { return {-1, -1, -1}; }

/// Holds a batch item against golden values: where `stable`, masks must be equal and values within 1e-3 (1e-5 on
/// average).
inline void expect_matches_golden(const SoftSplat& ours, const ValidityMask& mask, const Golden& render,
                                  std::size_t item, const ValidityMask& stable, const DepthMap* depth) {
  ASSERT_EQ(ours.valid.size(), mask.size());
  const std::size_t pixels = mask.size().pixels();
  std::size_t mask_flips = 0, compared = 0, worst_at = 0;
  double worst = 0, sum = 0, worst_depth = 0;
  for (std::size_t p = 0; p < pixels; ++p) {
    if (stable.data()[p] == 0) continue;
    if (ours.valid.data()[p] != mask.data()[p]) {
      ++mask_flips;
      continue;
    }
    const RgbF c = ours.valid.data()[p] != 0 ? ours.colour.data()[p] : hole_colour();
    for (const auto& [channel, value] : {std::pair{0, c.r}, std::pair{1, c.g}, std::pair{2, c.b}}) {
      const double difference =
          std::fabs(value - render.at((item * 3 + static_cast<std::size_t>(channel)) * pixels + p));
      sum += difference;
      ++compared;
      if (difference > worst) {
        worst = difference;
        worst_at = p;
      }
    }
    if (depth != nullptr)
      worst_depth = std::max<double>(
          worst_depth, std::fabs(ours.depth.data()[p] - depth->data()[p]) / std::max(1.0F, depth->data()[p]));
  }
  const auto width = static_cast<std::size_t>(mask.width());
  EXPECT_EQ(mask_flips, 0U) << "stable pixels whose mask differs";
  EXPECT_LE(worst, 1e-3) << "worst colour at (" << worst_at % width << ", " << worst_at / width << ")";
  EXPECT_LE(sum / static_cast<double>(std::max<std::size_t>(compared, 1)), 1e-5) << "mean colour difference";
  EXPECT_LE(worst_depth, 1e-3) << "worst depth";
}

}  // namespace uwv::testing
