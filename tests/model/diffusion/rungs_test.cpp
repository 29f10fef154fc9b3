// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/rungs.h"

#include <gmock/gmock.h>

#include "uwv/core/processor.h"

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
  const bool fast = processor_units().bf16();
  EXPECT_EQ(choose().form, fast ? LinearForm::bf16 : LinearForm::f32);
  if (fast) {
    EXPECT_THAT(choose().reasons, Contains(HasSubstr("official")));
  }
  options_.weights = WeightsForm::f32;
  EXPECT_EQ(choose().form, LinearForm::f32);
}

TEST_F(RungsTest, ACheckpointIn8BitsIsRunInThem) {
  job_.pass.stored = DType::i8;
  EXPECT_EQ(choose().form, processor_units().int8() ? LinearForm::int8 : LinearForm::int8_stored);
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

TEST_F(RungsTest, ALimitThatHoldsNoWholeCheckpointStreamsIt) {
  job_.pass.stored = DType::bf16;
  options_.memory_limit = "8G";
  const Rungs rungs = choose();
  EXPECT_TRUE(rungs.streamed);
  EXPECT_THAT(rungs.reasons, Contains(HasSubstr("read block by block")));
}

}  // namespace
}  // namespace uwv::model
