// SPDX-License-Identifier: Apache-2.0
#include "uwv/eval/texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace uwv {
namespace {

struct Named {
  std::string name;
  Texture texture;
};

std::vector<Named> all_textures(double period) {
  const Colour a{0.2F, 0.3F, 0.4F};
  const Colour b{0.9F, 0.8F, 0.7F};
  return {{"flat", Texture::flat(a)},
          {"checker", Texture::checker(a, b, period)},
          {"gradient", Texture::gradient(a, b, period)},
          {"noise", Texture::noise(a, period, 5)},
          {"wood", Texture::wood(a, b, period, 6)}};
}

TEST(Texture, StaysInRangeAndIsSmooth) {
  const double period = 0.5;
  for (const Named& named : all_textures(period)) {
    for (int i = 0; i < 4000; ++i) {
      const Eigen::Vector3d x(0.013 * i, 3 * std::sin(0.1 * i), std::cos(0.37 * i));
      const Colour here = named.texture.at(x);
      const Colour near = named.texture.at(x + Eigen::Vector3d(period / 1000, period / 1000, 0));
      ASSERT_GE(here.minCoeff(), 0.0F) << named.name;
      ASSERT_LE(here.maxCoeff(), 1.0F) << named.name;
      ASSERT_LE((here - near).cwiseAbs().maxCoeff(), 0.03F) << named.name << " jumps at " << x.transpose();
    }
  }
}

TEST(Texture, CheckerHasItsColoursInTheMiddleOfItsSquares) {
  const Colour a{0.1F, 0.2F, 0.3F};
  const Colour b{0.9F, 0.8F, 0.7F};
  const Texture texture = Texture::checker(a, b, 2.0);
  EXPECT_LT((texture.at({1, 1, 0}) - a).norm(), 0.02F);
  EXPECT_LT((texture.at({3, 1, 0}) - b).norm(), 0.02F);
  EXPECT_LT((texture.at({3, 3, 0}) - a).norm(), 0.02F);
}

TEST(Texture, SeedsGiveOtherTexturesAndTheSameSeedTheSame) {
  const Colour mean{0.5F, 0.5F, 0.5F};
  const Eigen::Vector3d x(0.3, -0.7, 0.2);
  EXPECT_EQ(Texture::noise(mean, 1, 1).at(x), Texture::noise(mean, 1, 1).at(x));
  EXPECT_NE(Texture::noise(mean, 1, 1).at(x), Texture::noise(mean, 1, 2).at(x));
}

TEST(Texture, RefusesAPeriodThatIsNotPositive) {
  EXPECT_THROW(Texture::noise(Colour::Zero(), 0, 1), std::invalid_argument);
  EXPECT_THROW(Texture::checker(Colour::Zero(), Colour::Ones(), -1), std::invalid_argument);
}

}  // namespace
}  // namespace uwv
