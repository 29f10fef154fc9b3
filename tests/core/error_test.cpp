// SPDX-License-Identifier: Apache-2.0
#include "uwv/core/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "uwv/core/monitor.h"

namespace uwv {
namespace {

TEST(Error, EveryCodeHasItsOwnName) {
  std::set<std::string_view> names;
  for (int code = 0; code <= static_cast<int>(ErrorCode::cancelled); ++code)
    names.insert(to_string(static_cast<ErrorCode>(code)));
  EXPECT_EQ(names.size(), static_cast<std::size_t>(ErrorCode::cancelled) + 1);
  EXPECT_EQ(names.count("unknown"), 0U);
  EXPECT_EQ(to_string(ErrorCode::file_damaged), "file_damaged");
}

TEST(Error, FailCarriesCodeAndSentence) {
  try {
    fail(ErrorCode::size_mismatch, "{}: depth is {}x{}", "a.npy", 3, 2);
    FAIL() << "fail() returned";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::size_mismatch);
    EXPECT_STREQ(error.what(), "a.npy: depth is 3x2");
  }
}

TEST(Error, RequireBlamesTheCaller) {
  EXPECT_NO_THROW(require(true, "unused"));
  try {
    require(false, "alpha is {}", 7);
    FAIL() << "require() returned";
  } catch (const std::invalid_argument& mistake) {
    EXPECT_STREQ(mistake.what(), "alpha is 7");
  }
}

TEST(Monitor, NeverStopsByDefault) {
  Monitor monitor;
  EXPECT_NO_THROW(monitor.step("render", 1, 0));
  EXPECT_NO_THROW(monitor.warn("nothing listens"));
}

TEST(Monitor, RefusalBecomesCancelled) {
  struct StopAfterTwo : Monitor {
    bool progress(std::string_view, long done, long) override { return done < 2; }
  } monitor;
  EXPECT_NO_THROW(monitor.step("render", 1, 5));
  try {
    monitor.step("render", 2, 5);
    FAIL() << "step() went on";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
    EXPECT_THAT(error.what(), testing::HasSubstr("'render' after step 2"));
  }
}

}  // namespace
}  // namespace uwv
