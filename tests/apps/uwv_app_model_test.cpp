// SPDX-License-Identifier: Apache-2.0
// The video diffusion model as a user gives it: a folder that works, folders that do not, and runs that are stopped.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/clip_maker.h"
#include "apps/program.h"
#include "support/matchers.h"

namespace uwv::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

class UwvAppWithModel : public ::testing::Test {
 protected:
  UwvAppWithModel() : weights_(fs::absolute(uwv::testing::fixture_folder("pipeline")).string()) {
    make_clip(folder_, {});
  }
  /// Of the tests' model, but for the flags in `more`, which take the place of its own.
  std::vector<std::string> arguments(const std::string& out, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all = run_arguments(out, more);
    const std::pair<const char*, std::string> own[] = {{"--model", weights_ + "/wan"},
                                                       {"--transformer", weights_ + "/uniview"},
                                                       {"--steps", "2"},
                                                       {"--threads", "1"},
                                                       {"--prompt-cache", "prompts"},
                                                       {"--prompt", "a white rabbit"}};
    for (const auto& [flag, value] : own)
      if (std::find(all.begin(), all.end(), flag) == all.end()) all.insert(all.end(), {flag, value});
    return all;
  }
  Outcome run(const std::string& out, const std::vector<std::string>& more = {}) const {
    return run_app(folder_.path().string(), arguments(out, more));
  }
  json completion(const std::string& out) const { return json::parse(folder_.read(out + "/run.json"))["stages"][2]; }

  std::string weights_;
  TempFolder folder_;
};

// Behind a plain BLAS of the system's the model would be ten times slower in float32.
TEST_F(UwvAppWithModel, LibtorchMultipliesMatricesByItsOwnLibrary) {
  EXPECT_THAT(run_app(folder_.path().string(), {"doctor"}).out,
              ::testing::ContainsRegex("products +by [^\n]*libtorch_cpu"));
}

TEST_F(UwvAppWithModel, CompletesTheClipAndRecordsHow) {
  const Outcome outcome = run("out", {"--preview"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(fs::exists(folder_.file("out/result.mp4")));
  EXPECT_TRUE(fs::exists(folder_.file("out/preview.png")));
  const json record = json::parse(folder_.read("out/run.json"));
  const json stage = record["stages"][2];
  EXPECT_EQ(stage["method"], "video diffusion model") << stage.dump(1);
  EXPECT_EQ(stage["steps"], 2);
  EXPECT_EQ(stage["seed"], 42);
  EXPECT_EQ(stage["parts"].size(), 4U);
  EXPECT_EQ(record["options"]["steps"], 2);
  EXPECT_EQ(record["options"]["prompt"], "a white rabbit");
  EXPECT_GT(record["inputs"]["model"]["files"], 5);
}

TEST_F(UwvAppWithModel, ResumesAndRedoesOnlyWhatItsOptionsChange) {
  ASSERT_EQ(run("out").exit_code, 0);
  const auto first = results(folder_.file("out"));
  ASSERT_EQ(run("out").exit_code, 0);
  EXPECT_EQ(completion("out")["status"], "resumed");
  ASSERT_EQ(run("out", {"--seed", "7"}).exit_code, 0);
  EXPECT_EQ(completion("out")["status"], "done");
  EXPECT_EQ(json::parse(folder_.read("out/run.json"))["stages"][1]["status"], "resumed");
  EXPECT_NE(results(folder_.file("out")).at("result.mp4"), first.at("result.mp4"));
  ASSERT_EQ(run("again").exit_code, 0);
  EXPECT_EQ(results(folder_.file("again")).at("result.mp4"), first.at("result.mp4"));
}

TEST_F(UwvAppWithModel, OtherWeightsInTheSameFolderMakeItAnew) {
  fs::copy(weights_ + "/wan", folder_.file("wan"), fs::copy_options::recursive);
  const std::vector<std::string> more = {"--model", "wan"};
  ASSERT_EQ(run("out", more).exit_code, 0);
  fs::last_write_time(folder_.file("wan/vae/diffusion_pytorch_model.safetensors"),
                      fs::file_time_type::clock::now() + std::chrono::seconds(5));
  ASSERT_EQ(run("out", more).exit_code, 0);
  EXPECT_EQ(completion("out")["status"], "done");
}

TEST_F(UwvAppWithModel, RefusesFoldersThatMissAPartBeforeAnythingIsMade) {
  const auto refused = [&](const std::vector<std::string>& more, const std::string& part) {
    const Outcome outcome = run("out", more);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr(part));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(fs::exists(folder_.file("out")));
  };
  fs::create_directories(folder_.file("half/vae"));
  refused({"--model", "nowhere"}, "nowhere");
  refused({"--model", "half"}, "vae/config.json");
  refused({"--transformer", "half"}, "config.json");
  refused({"--steps", "0"}, "--steps");
  refused({"--sampler", "ddim"}, "euler_plain");
  refused({"--complete", "inpaint"}, "--complete inpaint");
  refused({"--prompt-embeds", "nowhere.safetensors"}, "nowhere.safetensors");
}

TEST_F(UwvAppWithModel, CtrlCStopsWithinTheModelAndTheNextRunGoesOn) {
  Program program(folder_.path().string(), arguments("out", {"--steps", "1000"}));
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!fs::exists(folder_.file("out/.partial-completion")) && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  program.signal(SIGINT);
  EXPECT_EQ(program.wait().exit_code, 130);
  EXPECT_FALSE(fs::exists(folder_.file("out/result.mp4")));
  EXPECT_FALSE(fs::exists(folder_.file("out/.partial-completion")));
  ASSERT_EQ(run("out").exit_code, 0);
  EXPECT_EQ(json::parse(folder_.read("out/run.json"))["stages"][1]["status"], "resumed");
}

TEST_F(UwvAppWithModel, APlanSaysWhatItWouldTakeWithoutLoadingWeights) {
  const Outcome plan = run_app(folder_.path().string(), {"model", "plan", "--model", weights_ + "/wan", "--size",
                                                         "832x480", "--frames", "81", "--memory-limit", "16G"});
  EXPECT_EQ(plan.exit_code, 0) << plan.err;
  EXPECT_THAT(plan.out, HasSubstr("decoding"));
  EXPECT_THAT(plan.out, HasSubstr("s per step"));
  EXPECT_EQ(run_app(folder_.path().string(), {"model", "plan", "--model", "nowhere", "--size", "64x64"}).exit_code, 2);
}

TEST_F(UwvAppWithModel, AConvertedCheckpointRunsInItsEightBits) {
  const auto convert = [&](const std::string& out) {
    return run_app(folder_.path().string(),
                   {"model", "convert", "--model", weights_ + "/wan", "--weights", "int8", "--out", out});
  };
  const Outcome converted = convert("small");
  ASSERT_EQ(converted.exit_code, 0) << converted.err;
  EXPECT_THAT(converted.out, HasSubstr("tensors rounded"));
  const Outcome outcome = run("out", {"--model", "small", "--transformer", "small/transformer"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(completion("out")["choices"].dump(), HasSubstr("weights int8"));
  const Outcome again = convert("small");
  EXPECT_EQ(again.exit_code, 2) << again.out;
  EXPECT_THAT(again.err, HasSubstr("small"));
}

TEST_F(UwvAppWithModel, KnownTokensAreLeftOutAndCounted) {
  ASSERT_EQ(run("out", {"--skip-known", "0"}).exit_code, 0);
  EXPECT_THAT(completion("out")["skipped"].dump(), HasSubstr("tokens"));
}

TEST_F(UwvAppWithModel, ADeviceThatIsNotThereIsNamed) {
  const Outcome outcome = run("out", {"--device", "cuda:7"});
  EXPECT_EQ(outcome.exit_code, 2) << outcome.out;
  EXPECT_THAT(outcome.err, HasSubstr("--device cuda:7"));
  EXPECT_THAT(outcome.err, HasSubstr("cpu"));
}

}  // namespace
}  // namespace uwv::test
