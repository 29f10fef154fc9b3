// SPDX-License-Identifier: Apache-2.0
// Ctrl-C and kill -9 in mid-run.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

#include "apps/clip_maker.h"
#include "apps/program.h"

namespace uwv::test {
namespace {

namespace fs = std::filesystem;

const ClipSpec long_clip = {.size = {320, 240}, .frames = 300};
const std::vector<std::string> whole = {"--max-frames", "0", "--complete", "inpaint"};

/// Waits until the stage has started to write. False when it never did.
bool wait_for(const std::string& path) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(120);
  while (!fs::exists(path)) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

TEST(Interrupt, CtrlCLeavesNothingOfAnUnfinishedStage) {
  const TempFolder folder;
  make_clip(folder, long_clip);
  const auto before = listing(folder.path().string());
  Program program(folder.path().string(), run_arguments("out", whole));
  ASSERT_TRUE(wait_for(folder.file("out/.partial-conditioning/colour.mp4")));
  program.signal(SIGINT);
  const Outcome outcome = program.wait();
  EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
  EXPECT_EQ(listing(folder.path().string()), before);
}

TEST(Interrupt, CtrlCKeepsFinishedStages) {
  const TempFolder folder;
  make_clip(folder, long_clip);
  Program program(folder.path().string(), run_arguments("out", whole));
  ASSERT_TRUE(wait_for(folder.file("out/.partial-completion/result.mp4")));
  program.signal(SIGINT);
  EXPECT_EQ(program.wait().exit_code, 130);
  EXPECT_TRUE(fs::exists(folder.file("out/colour.mp4")));
  EXPECT_FALSE(fs::exists(folder.file("out/.partial-completion")));
  EXPECT_FALSE(fs::exists(folder.file("out/result.mp4")));
}

TEST(Interrupt, KilledRunsGoOnToTheSameBytes) {
  const TempFolder folder;
  make_clip(folder, long_clip);
  for (const char* stage : {"out/.partial-conditioning/colour.mp4", "out/.partial-completion/result.mp4"}) {
    Program program(folder.path().string(), run_arguments("out", whole));
    ASSERT_TRUE(wait_for(folder.file(stage))) << stage;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    program.signal(SIGKILL);
    EXPECT_EQ(program.wait().exit_code, 128 + SIGKILL);
  }
  EXPECT_EQ(run_app(folder.path().string(), run_arguments("out", whole)).exit_code, 0);
  EXPECT_EQ(run_app(folder.path().string(), run_arguments("undisturbed", whole)).exit_code, 0);
  const auto resumed = results(folder.file("out")), undisturbed = results(folder.file("undisturbed"));
  ASSERT_EQ(resumed.size(), undisturbed.size());
  for (const auto& [name, bytes] : undisturbed)
    EXPECT_TRUE(resumed.contains(name) && resumed.at(name) == bytes) << name << " differs";
}

}  // namespace
}  // namespace uwv::test
