// SPDX-License-Identifier: Apache-2.0
// Every example trajectory must be one that works.
#include <gtest/gtest.h>

#include <filesystem>

#include "uwv/trajectory/target_path.h"

namespace uwv {
namespace {

TEST(Examples, EveryTrajectoryGivesAPath) {
  const Size size{832, 480};
  const Intrinsics intrinsics = Intrinsics::from_fov_x(1, size);
  int found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(UWV_EXAMPLES)) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() != ".json" || name.ends_with("_right.json")) continue;
    SCOPED_TRACE(name);
    ++found;
    const TrajectorySpec spec = read_trajectory(entry.path());
    const Rigid3 locked_off;
    const PathContext context = make_context(spec, intrinsics, size, {&locked_off, 1}, 81, 2.5, false);
    const TargetPath path = build_path(spec, context);
    EXPECT_EQ(static_cast<long>(path.frames.size()), spec.frames);
    const PathSummary summary = summarize(path, context);
    EXPECT_GT(summary.max_translation, 0.1) << "it should move";
    EXPECT_LT(summary.max_rotation_deg, 60) << "and stay where a model can complete the picture";
  }
  EXPECT_GE(found, 5);
}

}  // namespace
}  // namespace uwv
