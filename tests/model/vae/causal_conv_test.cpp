// SPDX-License-Identifier: Apache-2.0
// The convolution over three frames in each of its forms, against one over a whole clip in float64.
#include <gtest/gtest.h>

#include "model/layers/torch_scope.h"
#include "model/tensor_support.h"
#include "model/vae/frame_conv.h"
#include "support/temp_folder.h"

namespace uwv::model {
namespace {

using uwv::testing::near;

struct Case {
  const char* name;
  std::int64_t channels, results, side;
  std::int64_t remembered;  ///< Channels of what is kept of a frame.
};

class CausalConvForms : public ::testing::TestWithParam<Case> {
 protected:
  CausalConvForms() {
    at::manual_seed(8);
    const auto& [name, channels, results, side, remembered] = GetParam();
    weight_ =
        at::randn({results, channels, 3, side, side}) / std::sqrt(3.0 * static_cast<double>(channels * side * side));
    bias_ = at::randn({results});
    path_ = (folder_.path() / "conv.safetensors").string();
    uwv::testing::write_safetensors(path_, {{"conv.weight", weight_}, {"conv.bias", bias_}});
  }
  CausalConv open(at::ScalarType type) const { return {WeightFiles::open(path_), "conv", {type, true}}; }

  /// (frames, H, W, O) of (frames, H, W, C); frames before the first are zeros.
  at::Tensor plain(const at::Tensor& clip) const {
    const std::int64_t side = GetParam().side, pad = side / 2;
    const at::Tensor padded =
        at::constant_pad_nd(clip.permute({3, 0, 1, 2}).to(at::kDouble), {pad, pad, pad, pad, 2, 0});
    return at::conv3d(padded.unsqueeze(0), weight_.to(at::kDouble), bias_.to(at::kDouble))[0].permute({1, 2, 3, 0});
  }

  TorchScope scope_{2};
  test::TempFolder folder_;
  std::string path_;
  at::Tensor weight_, bias_;
};

TEST_P(CausalConvForms, SeesTheFrameAndTheTwoBefore) {
  for (const at::ScalarType type : {at::kFloat, at::kBFloat16}) {
    const CausalConv conv = open(type);
    for (const auto& [height, width] : {std::pair{1, 1}, {3, 5}, {40, 33}}) {
      const at::Tensor clip = at::randn({5, height, width, GetParam().channels}).to(type);
      const at::Tensor wanted = plain(clip);
      FramePool pool(type);
      FrameHistory history, added;
      for (std::int64_t i = 0; i < clip.size(0); ++i) {
        SCOPED_TRACE(::testing::Message() << type << " " << height << "x" << width << " frame " << i);
        const double tolerance = type == at::kFloat ? 2e-5 : 0.05;
        history.push(pool.copy_of(clip[i]));
        EXPECT_TRUE(near(conv(history, pool), wanted[i], tolerance));
        at::Tensor sum = at::ones_like(wanted[i], type).contiguous();
        added.push(pool.copy_of(clip[i]));
        conv.add_to(sum, added, pool);
        EXPECT_TRUE(near(sum, wanted[i] + 1, tolerance));
      }
      EXPECT_EQ(history.size(), 2U);
      EXPECT_EQ(history.frame(0).size(2), GetParam().remembered);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, CausalConvForms,
                         ::testing::Values(Case{"by_frame", 32, 48, 3, 32}, Case{"side_by_side", 3, 96, 3, 3},
                                           Case{"in_shares", 96, 3, 3, 9}, Case{"in_wide_shares", 96, 32, 3, 96},
                                           Case{"of_one_pixel", 32, 64, 1, 32}),
                         [](const auto& shape) { return std::string(shape.param.name); });

}  // namespace
}  // namespace uwv::model
