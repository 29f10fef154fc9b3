// SPDX-License-Identifier: Apache-2.0
#include "uwv/pipeline/environment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace uwv {
namespace {

using ::testing::MatchesRegex;

TEST(Environment, TheBuildHasAnIdentity) {
  const std::string id = build_id();
  EXPECT_THAT(id, MatchesRegex("([0-9a-f][0-9a-f])+")) << "the linker was asked for one";
  EXPECT_GE(id.size(), 16U);
  EXPECT_EQ(build_id(), id);
}

TEST(Environment, VersionsNameThisLibraryFirst) {
  const auto versions = component_versions();
  ASSERT_FALSE(versions.empty());
  EXPECT_EQ(versions.front().first, "uwv");
  EXPECT_EQ(versions.front().second, version());
  for (const auto& [name, text] : versions) EXPECT_FALSE(text.empty()) << name;
}

}  // namespace
}  // namespace uwv
