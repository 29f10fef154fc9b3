// SPDX-License-Identifier: Apache-2.0
// PSNR and SSIM against scikit-image's values, for every picture the golden data names.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "support/matchers.h"
#include "uwv/eval/image_metrics.h"
#include "uwv/io/safetensors.h"

namespace uwv {
namespace {

MetricImage load(const SafeTensors& file, const std::string& name) {
  const std::vector<std::size_t>& shape = file.info(name).shape;  // height, width, channels
  return {Size{static_cast<int>(shape.at(1)), static_cast<int>(shape.at(0))}, static_cast<int>(shape.at(2)),
          file.as_float(name)};
}

class Parity : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string folder = testing::fixture_folder("metrics");
    pictures_ = SafeTensors::open(folder + "/images.safetensors");
    std::ifstream in(folder + "/values.json");
    values_ = nlohmann::json::parse(in);
    ASSERT_FALSE(values_.empty());
  }

  // Calls check(wanted values, that picture, the reference) for every picture.
  template <class Check>
  void for_each_picture(const Check& check) {
    const MetricImage reference = load(*pictures_, "reference");
    for (const auto& [name, wanted] : values_.items()) {
      SCOPED_TRACE(name);
      check(wanted, load(*pictures_, name), reference);
    }
  }

  std::optional<SafeTensors> pictures_;
  nlohmann::json values_;
};

TEST_F(Parity, metrics_psnr) {
  for_each_picture([](const nlohmann::json& wanted, const MetricImage& picture, const MetricImage& reference) {
    EXPECT_NEAR(mean_squared_error(picture, reference), wanted.at("mse").get<double>(), 1e-9);
    if (wanted.at("psnr").is_string()) {
      EXPECT_EQ(wanted.at("psnr"), "inf");
      EXPECT_EQ(psnr(picture, reference), HUGE_VAL);
    } else {
      EXPECT_NEAR(psnr(picture, reference), wanted.at("psnr").get<double>(), 1e-6);
    }
  });
}

TEST_F(Parity, metrics_ssim) {
  for_each_picture([](const nlohmann::json& wanted, const MetricImage& picture, const MetricImage& reference) {
    EXPECT_NEAR(ssim(picture, reference), wanted.at("ssim").get<double>(), 1e-7);
    EXPECT_NEAR(ssim(picture, reference, nullptr, {.sample_covariance = true}),
                wanted.at("ssim_sample_covariance").get<double>(), 1e-7);
    EXPECT_NEAR(ssim(picture.grey(), reference.grey()), wanted.at("ssim_gray").get<double>(), 1e-7);
  });
}

TEST_F(Parity, metrics_ssim_map) {
  const std::string prefix = "ssim_map_";
  const MetricImage reference = load(*pictures_, "reference");
  int maps = 0;
  for (const std::string& name : pictures_->names()) {
    if (!name.starts_with(prefix)) continue;
    SCOPED_TRACE(name);
    ++maps;
    const std::vector<Image<double>> wanted = load(*pictures_, name).planes();
    const std::vector<Image<double>> actual = ssim_map(load(*pictures_, name.substr(prefix.size())), reference);
    ASSERT_EQ(actual.size(), wanted.size());
    for (std::size_t c = 0; c < actual.size(); ++c) {
      testing::Worst worst(1e-6);  // the golden map is stored as float32
      for (int y = 0; y < actual[c].height(); ++y)
        for (int x = 0; x < actual[c].width(); ++x) worst.see(x, y, std::abs(actual[c](x, y) - wanted[c](x, y)));
      EXPECT_EQ(worst.failed(), 0U) << "channel " << c << ", worst at (" << worst.x() << ", " << worst.y()
                                    << "): off by " << worst.difference();
    }
  }
  EXPECT_GT(maps, 0);
}

}  // namespace
}  // namespace uwv
