// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/rungs.h"

#include <gmock/gmock.h>

#include "model/complaint.h"
#include "uwv/model/compute_devices.h"

namespace uwv::model {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

class RungsTest : public ::testing::Test {
 protected:
  RungsTest() {
    job_.clip = {17, 240, 416};
    job_.pass.tokens = 1950;
    options_.memory_limit = "64G";
  }
  Rungs choose() const { return choose_rungs(options_, at::kCPU, TransformerConfig{}, VaeConfig{}, job_); }

  ModelOptions options_;
  JobSize job_;
};

TEST_F(RungsTest, AFloatCheckpointIsRunExactly) {
  job_.pass.stored = DType::f32;
  EXPECT_EQ(choose().form, LinearForm::f32);
}

TEST_F(RungsTest, ABfloat16CheckpointIsRunAsTheOfficialCodeDoesWhereThatIsFast) {
  job_.pass.stored = DType::bf16;
  const bool fast = fast_numbers().bf16;
  EXPECT_EQ(choose().form, fast ? LinearForm::bf16 : LinearForm::f32);
  if (fast) {
    EXPECT_THAT(choose().reasons, Contains(HasSubstr("official")));
  }
  options_.weights = WeightsForm::f32;
  EXPECT_EQ(choose().form, LinearForm::f32);
}

TEST_F(RungsTest, ACheckpointIn8BitsIsRunInThem) {
  job_.pass.stored = DType::i8;
  EXPECT_EQ(choose().form, fast_numbers().int8 ? LinearForm::int8 : LinearForm::int8_stored);
}

TEST_F(RungsTest, TilesAreThoseAskedFor) {
  EXPECT_EQ(choose().vae.tile, 0);
  EXPECT_TRUE(choose().vae.winograd);
  options_.vae_tile = 256;
  EXPECT_EQ(choose().vae.tile, 256);
  for (const int bad : {-8, 24, 36, 20000}) {
    options_.vae_tile = bad;
    EXPECT_THROW(options_.check(), std::invalid_argument) << bad;
  }
}

TEST_F(RungsTest, WithATinyDecoderOnlyEncodingIsCutIntoBands) {
  const VaeConfig vae;
  VaeOptions whole;
  const double encoding = vae_cost(vae, whole, job_.clip, VaeWay::encode).bytes;
  EXPECT_GT(vae_bytes(vae, whole, job_), encoding);
  job_.fast = TinyVaeSizes{};
  EXPECT_EQ(vae_bytes(vae, whole, job_), encoding);
  EXPECT_LT(decoding_cost(vae, whole, job_).bytes, encoding);
  // A limit that holds encoding in one piece, but not decoding by the large decoder.
  options_.memory_limit = std::to_string(static_cast<long>(encoding * 1.26));
  const auto bands = [&] {
    return choose_rungs(options_, at::kCPU, TransformerConfig::wan_1_3b(), vae, job_).vae.bands;
  };
  EXPECT_EQ(bands(), 1);
  job_.fast.reset();
  EXPECT_GT(bands(), 1);
}

TEST_F(RungsTest, ALimitIsKeptEvenWhereEstimatesErr) {
  options_.stream = StreamChoice::on;
  const VaeConfig vae;
  VaeOptions whole;
  const double bytes = vae_bytes(vae, whole, job_);
  for (const auto& [share, in_one_piece] : {std::pair{1.2, false}, {1.3, true}}) {
    options_.memory_limit = std::to_string(static_cast<long>(bytes * share));
    const Rungs rungs = choose_rungs(options_, at::kCPU, TransformerConfig::wan_1_3b(), vae, job_);
    EXPECT_EQ(rungs.vae.bands == 1, in_one_piece) << share;
  }
}

TEST_F(RungsTest, ATinyDecoderThatDoesNotFitIsNamed) {
  job_.fast = TinyVaeSizes{};
  job_.fast->levels = {20000, 20000, 20000};
  options_.memory_limit = "8G";
  EXPECT_THAT(uwv::testing::complaint([&] { choose(); }), HasSubstr("the tiny decoder needs"));
}

TEST_F(RungsTest, PreviewsOfTheTinyDecoderLieBesideTheTransformerOnce) {
  const TinyVaeSizes sizes;
  const double weights = estimated_weight_bytes(sizes, VaePrecision::f32);
  PartCost transformer;
  transformer.bytes = 8e9;
  transformer.resting = 7.99e9;
  EXPECT_EQ(denoising_bytes(transformer, job_, VaePrecision::f32), 8e9);
  job_.previews = true;
  EXPECT_EQ(denoising_bytes(transformer, job_, VaePrecision::f32), 8e9);
  job_.fast = sizes;
  // At work after a step, when the step's own tokens are gone.
  const double working = estimated_working_bytes(sizes, job_.clip, VaePrecision::f32);
  EXPECT_EQ(denoising_bytes(transformer, job_, VaePrecision::f32), 7.99e9 + weights + working);
  transformer.resting = 1e9;
  EXPECT_EQ(denoising_bytes(transformer, job_, VaePrecision::f32), 8e9 + weights);
  job_.previews = false;
  EXPECT_EQ(denoising_bytes(transformer, job_, VaePrecision::f32), 8e9);
}

TEST_F(RungsTest, ALimitThatHoldsNoWholeCheckpointStreamsIt) {
  job_.pass.stored = DType::bf16;
  options_.memory_limit = "8G";
  const Rungs rungs = choose();
  EXPECT_TRUE(rungs.streamed);
  EXPECT_THAT(rungs.reasons, Contains(HasSubstr("read block by block")));
}

}  // namespace
}  // namespace uwv::model
