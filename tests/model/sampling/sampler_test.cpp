// SPDX-License-Identifier: Apache-2.0
#include "model/sampling/sampler.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "model/sampling/scheduler_config.h"
#include "model/tensor_support.h"
#include "support/matchers.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

namespace fs = std::filesystem;
using uwv::testing::fixture_folder;
using uwv::testing::near;

constexpr SamplerKind every_kind[] = {SamplerKind::euler, SamplerKind::euler_plain, SamplerKind::unipc,
                                      SamplerKind::unipc_legacy, SamplerKind::dpmpp};

/// A golden trajectory.
struct Walk {
  std::string name;
  SamplerOptions options;
  WeightFiles file;
  at::Tensor get(const std::string& tensor) const { return file.load(tensor, at::kFloat); }
};

std::vector<Walk> walks_in(const std::string& area) {
  std::vector<Walk> walks;
  for (const fs::directory_entry& folder : fs::directory_iterator(area)) {
    if (!folder.is_directory()) continue;
    SamplerOptions options = read_scheduler_config((folder.path() / "scheduler_config.json").string());
    const bool legacy = folder.path().filename().string().ends_with("_diffusers0.35.0");
    if (legacy && options.kind == SamplerKind::unipc) options.kind = SamplerKind::unipc_legacy;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      if (entry.path().extension() != ".safetensors") continue;
      WeightFiles file = WeightFiles::open(entry.path().string());
      options.steps = static_cast<int>(file.shape("timesteps").at(0));
      walks.push_back({entry.path().string(), options, file});
    }
  }
  return walks;
}

std::vector<Walk> walks() {
  std::vector<Walk> all = walks_in(fixture_folder("schedulers"));
  for (Walk& walk : walks_in(std::string(UWV_TEST_DATA) + "/schedulers_dpmpp")) all.push_back(std::move(walk));
  return all;
}

/// The model of the goldens' README, in place of a network.
at::Tensor velocity_of(const at::Tensor& x, const at::Tensor& c, double timestep) {
  const double s = timestep / 1000;
  return 0.6 * x - c + 0.3 * at::tanh(1.5 * x * (0.5 + s)) + 0.2 * at::sin(3 * x + 6 * s);
}

TEST(SamplerParity, TablesEqualTheReference) {
  const std::vector<Walk> all = walks();
  ASSERT_GT(all.size(), 10U);
  for (const Walk& walk : all) {
    const SamplerTable table = sampler_table(walk.options);
    EXPECT_TRUE(near(at::tensor(table.sigmas), walk.get("sigmas"), 1e-6)) << walk.name;
    const bool whole = walk.file.info("timesteps").dtype == DType::i64;
    EXPECT_TRUE(near(at::tensor(table.timesteps), walk.get("timesteps"), whole ? 0 : 1e-3)) << walk.name;
  }
}

TEST(SamplerParity, EachStepFromTheReferencesLatentsGivesItsNext) {
  for (const Walk& walk : walks()) {
    Sampler sampler(walk.options);
    const at::Tensor samples = walk.get("samples"), velocities = walk.get("model_outputs");
    for (int i = 0; i < walk.options.steps; ++i)
      EXPECT_TRUE(near(sampler.step(samples[i], velocities[i]), samples[i + 1], 2e-5)) << walk.name << ", step " << i;
  }
}

TEST(SamplerParity, AClosedLoopFollowsTheReference) {
  for (const Walk& walk : walks()) {
    Sampler sampler(walk.options);
    const at::Tensor samples = walk.get("samples"), c = walk.get("c");
    at::Tensor x = samples[0];
    for (int i = 0; i < walk.options.steps; ++i) {
      x = sampler.step(x, velocity_of(x, c, sampler.timestep()));
      EXPECT_TRUE(near(x, samples[i + 1], 2e-5)) << walk.name << ", step " << i;
    }
  }
}

TEST(Sampler, APerfectModelIsFollowedToItsClipByEverySamplerAndStepCount) {
  const at::Tensor clip = at::linspace(-2, 2, 24), noise = at::linspace(3, -1, 24).sin();
  for (const SamplerKind kind : every_kind) {
    for (const int steps : {1, 2, 3, 8, 1000}) {
      for (const double shift : {0.01, 1.0, 5.0, 100.0}) {
        Sampler sampler({kind, steps, shift});
        at::Tensor x = noise;
        for (int i = 0; i < steps; ++i) x = sampler.step(x, (x - clip) / sampler.sigma());
        EXPECT_TRUE(near(x, clip, 2e-3)) << to_string(kind) << ' ' << steps << " steps, shift " << shift;
      }
    }
  }
}

TEST(Sampler, HigherOrderIsNearerToTheExactAnswer) {
  // Clips that are normally distributed around `mean`: the best network's velocity and where it leads are known.
  const double spread = 0.5;
  const at::Tensor mean = at::linspace(-1, 1, 24), noise = at::linspace(3, -1, 24).sin();
  const auto error = [&](SamplerKind kind) {
    Sampler sampler({kind, 60, 3});
    at::Tensor x = noise;
    while (sampler.taken() < sampler.steps()) {
      const double s = sampler.sigma(), a = 1 - s, variance = a * a * spread * spread + s * s;
      const at::Tensor clip = mean + (x - a * mean) * (a * spread * spread / variance);
      x = sampler.step(x, (x - clip) / s);
    }
    return (x - (mean + spread * noise)).abs().max().item<double>();
  };
  EXPECT_LT(error(SamplerKind::unipc), 0.5 * error(SamplerKind::euler_plain));
  EXPECT_LT(error(SamplerKind::dpmpp), 0.5 * error(SamplerKind::euler_plain));
}

TEST(Sampler, TheOfficialTableShiftsItsSmallestSigmaTwiceAndThePlainOneOnce) {
  EXPECT_NEAR(sampler_table({SamplerKind::euler, 8, 5}).sigmas[7], 0.024414, 1e-6);
  EXPECT_NEAR(sampler_table({SamplerKind::euler_plain, 8, 5}).sigmas[7], 5 * 0.125 / 1.5, 1e-6);
  EXPECT_EQ(sampler_table(SamplerOptions::few_steps()).sigmas.size(), 5U);
}

TEST(Sampler, RefusesWhatIsNoNumberNamingTheStep) {
  for (const SamplerKind kind : every_kind) {
    Sampler sampler({kind, 4, 5});
    const at::Tensor x = sampler.step(at::ones({4}), at::ones({4}));
    try {
      sampler.step(x, at::full({4}, std::numeric_limits<float>::infinity()));
      FAIL() << "nothing was thrown";
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr("step 2 of 4"));
    }
  }
}

TEST(Sampler, OptionsOutOfRangeAreRefused) {
  EXPECT_THROW(SamplerOptions({SamplerKind::euler, 0, 5}).check(), std::invalid_argument);
  EXPECT_THROW(SamplerOptions({SamplerKind::euler, 1001, 5}).check(), std::invalid_argument);
  EXPECT_THROW(SamplerOptions({SamplerKind::euler, 8, 0}).check(), std::invalid_argument);
  EXPECT_THROW(SamplerOptions({SamplerKind::euler, 8, std::nan("")}).check(), std::invalid_argument);
  Sampler sampler({SamplerKind::euler, 1, 5});
  sampler.step(at::ones({1}), at::ones({1}));
  EXPECT_THROW(sampler.step(at::ones({1}), at::ones({1})), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::model
