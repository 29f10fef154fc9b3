// SPDX-License-Identifier: Apache-2.0
// Against sizes computed by the official Python code; UWV_FIXTURES=DIR points at another set of the same layout.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "uwv/io/resize_policy.h"

namespace uwv {
namespace {

TEST(TargetSize, metrics_target_hw) {
  const char* elsewhere = std::getenv("UWV_FIXTURES");
  const std::string path = std::string(elsewhere != nullptr ? elsewhere : UWV_TEST_DATA) + "/metrics/target_hw.json";
  std::ifstream file(path);
  ASSERT_TRUE(file) << "cannot open " << path;
  const nlohmann::json cases = nlohmann::json::parse(file);
  ASSERT_FALSE(cases.empty());
  for (const auto& item : cases) {
    ResizePolicy policy;
    policy.budget = {item.at("base_width"), item.at("base_height")};
    policy.max_side = item.at("max_res");
    const Size size = target_size({item.at("orig_w"), item.at("orig_h")}, policy);
    EXPECT_EQ(size.height, item.at("target_h_w").at(0).get<int>()) << item;
    EXPECT_EQ(size.width, item.at("target_h_w").at(1).get<int>()) << item;
  }
}

}  // namespace
}  // namespace uwv
