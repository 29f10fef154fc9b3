// SPDX-License-Identifier: Apache-2.0
// A short clip with known truth, as a file, for tests of whole runs.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/temp_folder.h"
#include "uwv/eval/stock_scenes.h"
#include "uwv/io/depth_source.h"
#include "uwv/io/image_file.h"
#include "uwv/pipeline/run.h"

namespace uwv::test {

class WarningMonitor : public Monitor {
 public:
  void warn(const std::string& sentence) override { warnings.push_back(sentence); }
  std::vector<std::string> warnings;
};

/// A clip of a room with its true depth and cameras, and the options of a run over it.
class FilmedRoom : public ::testing::Test {
 protected:
  /// Frames of a room past which the camera moves by `step` degrees of an orbit a frame.
  void film(int frames, double step_deg) { film(boxes_room({.size = {240, 136}}), frames, step_deg, 0); }

  void film(const StockScene& room, int frames, double step_deg, double seconds_a_frame) {
    ThreadPool pool;
    std::filesystem::create_directory(folder_.file("clip"));
    for (int i = 0; i < frames; ++i) {
      const Camera camera = orbit_camera(room.source, room.subject_in_world, i * step_deg * M_PI / 180);
      const SyntheticFrame frame = render(room.scene, camera, i * seconds_a_frame, pool, 2);
      write_png(folder_.file(fmt::format("clip/{:03}.png", i)), frame.colour);
      depths_.push_back(frame.depth);
      cameras_.push_back(camera);
    }
    options_.video = folder_.file("clip");
    options_.out = folder_.file("out");
    options_.no_resize = true;
    options_.traj = "left";
    options_.fov = 60;
    options_.renderer = RendererChoice::cpu;
  }

  nlohmann::json record() const {
    std::ifstream file(options_.out + "/run.json");
    return nlohmann::json::parse(file);
  }

  std::string error_of_run() {
    try {
      Monitor monitor;
      run(options_, monitor);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  struct DepthFit {
    double scale = 0;  ///< Of the estimate, relative to the truth; the median.
    double error = 0;  ///< Mean relative error of what is left.
  };
  /// A run's estimated depth beside the truth, after one scale for the whole clip.
  DepthFit depth_fit() {
    Monitor monitor;
    const auto estimated = open_depth(options_.out + "/geometry/depth.npz", {}, monitor);
    std::vector<double> ratios;
    DepthMap depth;
    for (std::size_t i = 0; i < depths_.size() && estimated->read(static_cast<long>(i), depth); ++i)
      for (std::size_t p = 0; p < depth.pixels().size(); ++p)
        if (depth.pixels()[p] > 0) ratios.push_back(depth.pixels()[p] / depths_[i].pixels()[p]);
    EXPECT_GT(ratios.size(), depths_.size() * depths_[0].pixels().size() / 2);
    std::vector<double> sorted = ratios;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    const double scale = sorted[sorted.size() / 2];
    double sum = 0;
    for (const double ratio : ratios) sum += std::abs(ratio / scale - 1);
    return {scale, sum / static_cast<double>(ratios.size())};
  }
  double depth_error() { return depth_fit().error; }

  TempFolder folder_;
  RunOptions options_;
  std::vector<DepthMap> depths_;  ///< The truth, as the cameras.
  std::vector<Camera> cameras_;
};

}  // namespace uwv::test
