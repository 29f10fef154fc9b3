// SPDX-License-Identifier: Apache-2.0
#include "model/vae/tiny_vae.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/layers/torch_scope.h"
#include "model/tensor_support.h"
#include "support/temp_folder.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using ::testing::HasSubstr;
using uwv::test::TempFolder;
using uwv::testing::near;
using uwv::testing::write_safetensors;

const std::string data = UWV_TEST_DATA "/taehv";

TEST(TinyVaeParity, AClipDecodesAsInPythonFourFramesAtATime) {
  const TorchScope scope(1);
  const TinyVae vae = TinyVae::open(data);
  const WeightFiles golden = WeightFiles::open(data + "/cases");
  Monitor monitor;
  std::vector<std::int64_t> firsts;
  std::vector<at::Tensor> parts;
  vae.decode(
      golden.view("latents"),
      [&](std::int64_t first, const at::Tensor& frames) {
        firsts.push_back(first);
        parts.push_back(frames);
      },
      monitor);
  EXPECT_THAT(firsts, ::testing::ElementsAre(0, 1, 5, 9));
  EXPECT_TRUE(near(at::cat(parts, 2), golden.view("decoded"), 1e-4));
}

TEST(TinyVaeParity, ASingleLatentMakesAPreview) {
  const TorchScope scope(1);
  const WeightFiles golden = WeightFiles::open(data + "/cases");
  Monitor monitor;
  const at::Tensor first = golden.view("latents").narrow(2, 0, 1);
  EXPECT_TRUE(near(TinyVae::open(data).decode(first, monitor), golden.view("decoded_first"), 1e-4));
}

TEST(TinyVae, Bfloat16StaysNear) {
  const TorchScope scope(1);
  VaeOptions options;
  options.precision = VaePrecision::bf16;
  const WeightFiles golden = WeightFiles::open(data + "/cases");
  Monitor monitor;
  const at::Tensor decoded = TinyVae::open(data, options).decode(golden.view("latents"), monitor);
  EXPECT_TRUE(near(decoded, golden.view("decoded"), 0.05));
}

TEST(TinyVae, OtherNetworksAndLatentsAreRefusedByName) {
  const TempFolder folder;
  write_safetensors(folder.file("other.safetensors"), {{"decoder.0.weight", at::ones({4, 4, 1, 1})}});
  EXPECT_THROW(
      {
        try {
          TinyVae::open(folder.path().string());
        } catch (const Error& error) {
          EXPECT_THAT(error.what(), HasSubstr("decoder.1.weight"));
          throw;
        }
      },
      Error);
  const TorchScope scope(1);
  EXPECT_NO_THROW(TinyVae::check(data, 16));
  EXPECT_THROW(TinyVae::check(data, 48), Error);
  Monitor monitor;
  const TinyVae vae = TinyVae::open(data);
  EXPECT_THROW(vae.decode(at::zeros({1, vae.z_dim() + 1, 1, 2, 2}), monitor), Error);
  EXPECT_THROW(vae.decode(at::full({1, vae.z_dim(), 1, 2, 2}, NAN), monitor), Error);
}

}  // namespace
}  // namespace uwv::model
