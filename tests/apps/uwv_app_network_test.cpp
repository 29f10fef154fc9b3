// SPDX-License-Identifier: Apache-2.0
// A depth network as a user gives it: a folder that works, and folders that do not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/clip_maker.h"
#include "apps/program.h"
#include "model/script_nets.h"

namespace uwv::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* manifest = R"({"format": 1, "name": "bright", "kind": "metric_depth",
  "input": {"resize": "longer_side", "side": 64}, "outputs": {"depth": 0}})";

class UwvAppWithNetwork : public testing::Test {
 protected:
  void SetUp() override {
    make_clip(folder_, {});
    fs::create_directory(folder_.file("net"));
    folder_.write("net/manifest.json", manifest);
    save_script(folder_.file("net/model.ts"), "def forward(self, x):\n    return 1.0 + x[:, 0]\n");
  }
  Outcome run(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"--video", "clip.mp4", "--depth-model", "net", "--traj",      "left",
                                          "--fov",   "60",       "--out",         "out", "--no-resize", "--no-layers"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_app(folder_.path().string(), arguments);
  }
  /// One line that contains `part`, and nothing left behind.
  void expect_refusal(const std::string& part) const {
    const Outcome outcome = run();
    EXPECT_EQ(outcome.exit_code, 2) << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr(part));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(fs::exists(folder_.file("out")));
  }

  TempFolder folder_;
};

TEST_F(UwvAppWithNetwork, TakesItsDepth) {
  const Outcome outcome = run();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto record = nlohmann::json::parse(folder_.read("out/run.json"));
  const auto& facts = record["stages"][0];
  EXPECT_EQ(facts["provider"], "network") << facts.dump(1);
  EXPECT_EQ(facts["network"]["name"], "bright");
  EXPECT_EQ(facts["network"]["depth"], "metres");
  EXPECT_EQ(record["options"]["depth_model"], "net");
  EXPECT_GT(record["stages"][1]["valid_share"], 0.2);

  EXPECT_EQ(run({"--alpha", "80"}).exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(folder_.read("out/run.json"))["stages"][0]["status"], "resumed");
  // Another network under the same name makes another geometry.
  save_script(folder_.file("net/model.ts"), "def forward(self, x):\n    return 3.0 + x[:, 0] + 0.0\n");
  EXPECT_EQ(run().exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(folder_.read("out/run.json"))["stages"][0]["status"], "done");
}

TEST_F(UwvAppWithNetwork, RefusesFoldersThatHoldNone) {
  fs::remove(folder_.file("net/manifest.json"));
  expect_refusal("manifest.json");
  folder_.write("net/manifest.json", manifest);
  folder_.write("net/model.ts", "no network at all");
  expect_refusal("model.ts");
  fs::remove(folder_.file("net/model.ts"));
  expect_refusal("model.ts");
  fs::remove_all(folder_.file("net"));
  expect_refusal("net");
}

TEST_F(UwvAppWithNetwork, RefusesAnswersOfAnotherSignature) {
  save_script(folder_.file("net/model.ts"), "def forward(self, x):\n    return x.mean()\n");
  expect_refusal("model.ts");
  save_script(folder_.file("net/model.ts"), "def forward(self, x, y):\n    return x\n");
  expect_refusal("model.ts");
}

TEST_F(UwvAppWithNetwork, IsNamedByTheDoctor) {
  EXPECT_THAT(run_app(folder_.path().string(), {"doctor"}).out, HasSubstr("--depth-model"));
}

}  // namespace
}  // namespace uwv::test
