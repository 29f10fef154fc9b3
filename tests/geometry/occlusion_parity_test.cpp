// SPDX-License-Identifier: Apache-2.0
// The reliable-depth filter against the official one.
#include <gtest/gtest.h>

#include <regex>

#include "support/fixture_tensors.h"
#include "support/matchers.h"
#include "uwv/geometry/reliability.h"

namespace uwv::testing {
namespace {

TEST(GeometryParity, occlusion_depth_edges) {
  int cases = 0;
  ThreadPool pool;
  for (const auto& path : fixture_files(fixture_folder("occlusion"), "depth_edges")) {
    const SafeTensors file = SafeTensors::open(path.string());
    for (const std::string& name : file.names()) {
      std::smatch parts;
      if (!std::regex_match(name, parts, std::regex(R"((.+)\.mask_w([0-9]+)_t([0-9.]+))"))) continue;
      SCOPED_TRACE(name);
      ReliabilityOptions options;
      options.window = std::stoi(parts[2]);
      options.ratio = std::stof(parts[3]);
      const auto depth = Golden(file, parts[1].str() + ".depth").picture<DepthMap>();
      EXPECT_MASK_AGREES(reliable_depth(depth, options, pool), Golden(file, name).picture<ValidityMask>(), 0.999);
      ++cases;
    }
  }
  EXPECT_GT(cases, 0);
}

/// What the official code makes of a network's answer: pixels outside the network's mask get depth 1000, intrinsics are
/// scaled to pixels, and the filter decides what is kept.
TEST(GeometryParity, occlusion_moge_post_processing) {
  int cases = 0;
  ThreadPool pool;
  for (const auto& path : fixture_files(fixture_folder("occlusion"), "run_moge")) {
    SCOPED_TRACE(path.string());
    const SafeTensors file = SafeTensors::open(path.string());
    auto depth = Golden(file, "in.depth").picture<DepthMap>();
    const auto mask = Golden(file, "in.mask").picture<ValidityMask>();
    for (std::size_t p = 0; p < mask.size().pixels(); ++p)
      if (mask.data()[p] == 0) depth.data()[p] = 1000;
    EXPECT_DEPTH_NEAR(depth, Golden(file, "depth").picture<DepthMap>(), 1e-6);
    const ValidityMask reliable = reliable_depth(depth, {}, pool);
    const Golden wanted(file, "masks");
    std::size_t agree = 0;
    for (std::size_t p = 0; p < mask.size().pixels(); ++p) agree += (wanted.at(p) != 0) == (reliable.data()[p] != 0);
    EXPECT_GE(static_cast<double>(agree), 0.999 * static_cast<double>(mask.size().pixels()));

    const Eigen::MatrixXd unit = Golden(file, "in.intrinsics_normalised").matrix(), k = Golden(file, "K").matrix();
    const Intrinsics ours = Intrinsics{unit(0, 0), unit(1, 1), unit(0, 2), unit(1, 2)}.resized({1, 1}, depth.size());
    EXPECT_NEAR(ours.fx, k(0, 0), 1e-3);
    EXPECT_NEAR(ours.fy, k(1, 1), 1e-3);
    EXPECT_NEAR(ours.cx, k(0, 2), 1e-3);
    EXPECT_NEAR(ours.cy, k(1, 2), 1e-3);
    EXPECT_LT((ours.inverse_matrix() - Golden(file, "K_inv").matrix()).cwiseAbs().maxCoeff(), 1e-6);
    ++cases;
  }
  EXPECT_GT(cases, 0);
}

}  // namespace
}  // namespace uwv::testing
