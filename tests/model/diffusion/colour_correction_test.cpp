// SPDX-License-Identifier: Apache-2.0
#include "model/diffusion/colour_correction.h"

#include "model/tensor_support.h"
#include "support/matchers.h"

namespace uwv::model {
namespace {

/// Frame `k` of (frames, height, width, 3) in [0, 1].
ImageFloat3 frame_of(const at::Tensor& clip, std::int64_t k) {
  const at::Tensor frame = clip[k].mul(255).contiguous();
  ImageFloat3 picture(static_cast<int>(frame.size(1)), static_cast<int>(frame.size(0)));
  for (std::size_t i = 0; i < picture.size().pixels(); ++i)
    picture.data()[i] = Eigen::Map<const Eigen::Vector3f>(frame.data_ptr<float>() + 3 * i);
  return picture;
}

ImageRgb rounded(const ImageFloat3& picture) {
  ImageRgb out(picture.size());
  for (std::size_t i = 0; i < picture.size().pixels(); ++i)
    out.data()[i] = ColourMap()((picture.data()[i] + Eigen::Vector3f::Constant(0.5F)).cast<double>());
  return out;
}

ColourMap fit_all(const ImageFloat3& generated, const ImageRgb& wanted) {
  return fit_colours(generated, wanted, ValidityMask(wanted.width(), wanted.height(), 1));
}

TEST(ColourCorrectionParity, EqualsTheOfficialFit) {
  const WeightFiles file = WeightFiles::open(uwv::testing::fixture_folder("metrics") + "/color_correct.safetensors");
  const at::Tensor generated = file.load("in.diffusion_results", at::kFloat);
  const at::Tensor golden = file.load("out", at::kFloat);
  const ColourMap map =
      fit_all(frame_of(generated, 0), rounded(frame_of(file.load("in.render_results", at::kFloat), 0)));
  for (std::int64_t k = 0; k < generated.size(0); ++k) {
    const ImageFloat3 from = frame_of(generated, k);
    ImageRgb corrected(from.size());
    for (std::size_t i = 0; i < from.size().pixels(); ++i) corrected.data()[i] = map(from.data()[i].cast<double>());
    EXPECT_IMAGE_NEAR(corrected, rounded(frame_of(golden, k)), 1);
  }
}

TEST(ColourCorrection, TakesBackAnAffineDrift) {
  ImageRgb wanted(16, 16);
  ImageFloat3 drifted(16, 16);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) {
      wanted(x, y) = {static_cast<std::uint8_t>(40 + 8 * x), static_cast<std::uint8_t>(50 + 7 * y),
                      static_cast<std::uint8_t>(30 + 5 * x + 3 * ((x * y) % 7))};
      const Rgb8 p = wanted(x, y);
      drifted(x, y) = {0.9F * p.r + 10, 1.1F * p.g - 5, 0.1F * p.r + 0.8F * p.b};
    }
  const ColourMap map = fit_all(drifted, wanted);
  for (std::size_t i = 0; i < wanted.size().pixels(); ++i) {
    const Rgb8 back = map(drifted.data()[i].cast<double>() + Eigen::Vector3d::Constant(0.4));
    EXPECT_NEAR(back.r, wanted.data()[i].r, 1);
    EXPECT_NEAR(back.b, wanted.data()[i].b, 1);
  }
}

TEST(ColourCorrection, PixelsThatAreNotKnownDoNotCount) {
  ImageFloat3 generated(8, 8);
  ImageRgb wanted(8, 8);
  ValidityMask known(8, 8, 1);
  for (int i = 0; i < 64; ++i) {
    wanted.data()[i] = {static_cast<std::uint8_t>(3 * i), static_cast<std::uint8_t>((i * 53) % 256),
                        static_cast<std::uint8_t>((i * 37) % 256)};
    generated.data()[i] = {1.0F * wanted.data()[i].r, 1.0F * wanted.data()[i].g, 1.0F * wanted.data()[i].b};
  }
  for (int i = 20; i < 40; ++i) {
    generated.data()[i] = Eigen::Vector3f(250, 0, 13);
    known.data()[i] = 0;
  }
  const ColourMap map = fit_colours(generated, wanted, known);
  EXPECT_LT((map.matrix - Eigen::Matrix3d::Identity()).norm(), 1e-6);
}

TEST(ColourCorrection, APictureOfOneColourStillGivesAMapToTheWantedColour) {
  const ColourMap map = fit_all(ImageFloat3(8, 8, Eigen::Vector3f(100, 100, 100)), ImageRgb(8, 8, Rgb8{10, 200, 90}));
  const Rgb8 mapped = map(Eigen::Vector3d(100, 100, 100) + Eigen::Vector3d::Constant(1e-3));
  EXPECT_NEAR(mapped.r, 10, 1);
  EXPECT_NEAR(mapped.g, 200, 1);
  EXPECT_THROW(fit_all(ImageFloat3(8, 8), ImageRgb(8, 9)), std::invalid_argument);
}

}  // namespace
}  // namespace uwv::model
