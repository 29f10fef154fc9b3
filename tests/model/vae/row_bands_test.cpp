// SPDX-License-Identifier: Apache-2.0
#include "model/vae/row_bands.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace uwv::model {
namespace {

VaeConfig config_of(std::vector<std::int64_t> dim_mult, std::int64_t blocks) {
  VaeConfig config;
  config.temperal_downsample.assign(dim_mult.size() - 1, true);
  config.dim_mult = std::move(dim_mult);
  config.num_res_blocks = blocks;
  return config;
}

const std::vector<VaeConfig>& configs() {
  static const std::vector<VaeConfig> all{VaeConfig{}, config_of({1, 2}, 1), config_of({1}, 3),
                                          config_of({1, 1, 2, 2, 4}, 2)};
  return all;
}

/// Input rows that rows `made` of a layer's result depend on.
Rows dependencies(RowLayer layer, std::int64_t height, Rows made) {
  switch (layer) {
    case RowLayer::convolution: return {std::max<std::int64_t>(0, made.begin - 1), std::min(height, made.end + 1)};
    case RowLayer::doubling:
      return {std::max<std::int64_t>(0, made.begin - 1) / 2, std::min(2 * height - 1, made.end) / 2 + 1};
    case RowLayer::halving: return {2 * made.begin, std::min(height, 2 * made.end + 1)};
  }
  return {};
}

std::int64_t result_height(RowLayer layer, std::int64_t height) {
  return layer == RowLayer::convolution ? height : layer == RowLayer::doubling ? 2 * height : height / 2;
}

TEST(RowBands, ALayerMakesEachRowOnceFromRowsItHas) {
  for (const RowLayer layer : {RowLayer::convolution, RowLayer::doubling, RowLayer::halving})
    for (std::int64_t height = 2; height <= 40; height += 2)
      for (std::int64_t length = 1; length <= height + 3; ++length) {
        std::int64_t made = 0, kept_from = 0, line = 0;
        for (std::int64_t begin = 0; begin <= height; begin += length) {
          BandLines lines{{begin, begin + length}};
          const BandStep step = band_step(layer, height, lines);
          EXPECT_EQ(lines.line.begin, line);
          line = lines.line.end;
          EXPECT_EQ(step.made.begin, made);
          made = step.made.end;
          // At hand is what was kept and what is fresh, and no more is kept than two rows.
          EXPECT_EQ(step.all.begin, kept_from);
          EXPECT_EQ(step.all.end, std::min(height, begin + length));
          EXPECT_LE(std::min(height, begin) - step.all.begin, 2);
          kept_from = step.keep_from;
          if (step.made.count() == 0) continue;
          const Rows needed = dependencies(layer, height, step.made);
          EXPECT_EQ(needed.begin, step.read.begin);
          EXPECT_LE(needed.end, step.read.end);
          EXPECT_EQ(step.at_top, layer != RowLayer::halving && step.made.begin == 0);
          EXPECT_EQ(step.at_bottom, step.made.end == result_height(layer, height));
        }
        EXPECT_EQ(made, result_height(layer, height));
      }
}

TEST(RowBands, ABlockHasTheRowsOfBothItsConvolutionsAndOfItsSum) {
  for (std::int64_t height = 1; height <= 40; ++height)
    for (std::int64_t length = 1; length <= height + 5; ++length) {
      std::int64_t made = 0, kept_from = 0;
      for (std::int64_t begin = 0; begin <= height + 1; begin += length) {
        BandLines lines{{begin, begin + length}};
        const BlockStep block = block_step(height, lines);
        EXPECT_EQ(block.first.all.begin, kept_from);
        kept_from = block.first.keep_from;
        EXPECT_EQ(block.second.made.begin, made);
        made = block.second.made.end;
        if (block.first.made.count() > 0) {
          EXPECT_GE(block.first.read.begin, block.first.all.begin);
          EXPECT_EQ(dependencies(RowLayer::convolution, height, block.first.made), block.first.read);
        }
        if (block.second.made.count() > 0) {
          EXPECT_EQ(dependencies(RowLayer::convolution, height, block.second.made), block.second.read);
          EXPECT_LE(block.second.made.end, block.first.all.end);
        }
      }
      EXPECT_EQ(made, height);
    }
}

void expect_every_row_once(const std::vector<BandRows>& bands, std::size_t levels, int most) {
  ASSERT_FALSE(bands.empty());
  EXPECT_LE(bands.size(), static_cast<std::size_t>(most));
  std::int64_t line = 0;
  for (const BandRows& band : bands) {
    EXPECT_EQ(band.lines.line.begin, line);
    EXPECT_GT(band.lines.line.end, line);
    line = band.lines.line.end;
  }
  for (std::size_t i = 0; i < levels; ++i) {
    std::int64_t in = 0, out = 0;
    for (const BandRows& band : bands) {
      EXPECT_EQ(band.levels[i].in.begin, in);
      EXPECT_EQ(band.levels[i].out.begin, out);
      in = band.levels[i].in.end;
      out = band.levels[i].out.end;
    }
    EXPECT_EQ(in, bands.front().levels[i].height);
    EXPECT_EQ(out, bands.front().levels[i].height);
  }
}

TEST(RowBands, EveryLevelMakesEveryRowOnceWhateverTheHeightAndTheBands) {
  for (const VaeConfig& config : configs())
    for (std::int64_t height = 1; height <= 200; ++height)
      for (const int most : {1, 2, 3, 4, 7, 16, 64}) {
        SCOPED_TRACE(testing::Message() << config.levels() << " levels, " << height << " rows, bands " << most);
        const auto decoder = decoder_bands(config, height, most);
        expect_every_row_once(decoder, config.levels(), most);
        for (const BandRows& band : decoder) EXPECT_GT(band.levels.back().out.count(), 0);
        const auto encoder = encoder_bands(config, height, most);
        expect_every_row_once(encoder, config.levels(), most);
        for (const BandRows& band : encoder) EXPECT_GT(band.levels.front().in.count(), 0);
      }
}

/// Numbers in a frame of each level's input, of the band that holds most, beside the mean.
double largest_to_mean(const std::vector<BandRows>& bands, const std::vector<double>& numbers_a_row) {
  double most = 0, sum = 0;
  for (const BandRows& band : bands) {
    double held = 0;
    for (std::size_t i = 0; i < band.levels.size(); ++i)
      held += numbers_a_row[i] * static_cast<double>(band.levels[i].in.count());
    most = std::max(most, held);
    sum += held;
  }
  return most / (sum / static_cast<double>(bands.size()));
}

TEST(RowBands, EachHoldsAboutAsMuch) {
  const VaeConfig config;
  for (const auto& [most, height] : {std::pair{2, 30}, {4, 30}, {6, 30}, {3, 60}, {5, 60}, {8, 60}, {8, 540}}) {
    const auto decoder = decoder_bands(config, height, most), encoder = encoder_bands(config, height, most);
    ASSERT_EQ(decoder.size(), static_cast<std::size_t>(most));
    ASSERT_EQ(encoder.size(), static_cast<std::size_t>(most));
    // Of rows as wide as the latents: channels by how much wider the level is. Bands are cut at rows of latents.
    const double tolerance = 1.1 + 0.9 * most / static_cast<double>(height);
    EXPECT_LT(largest_to_mean(decoder, {384, 384 * 2, 192 * 4, 96 * 8}), tolerance) << most << " of " << height;
    EXPECT_LT(largest_to_mean(encoder, {96 * 8, 192 * 4, 384 * 2, 384}), tolerance) << most << " of " << height;
  }
}

}  // namespace
}  // namespace uwv::model
