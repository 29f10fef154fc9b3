// SPDX-License-Identifier: Apache-2.0
#include "model/vae/tiny_vae_cost.h"

#include <algorithm>

#include "model/transformer/transformer_cost.h"
#include "model/weights/weight_files.h"

namespace uwv::model {
namespace {

constexpr double side = 8;           ///< Pixels a latent is wide.
constexpr double latent_frames = 4;  ///< Frames a latent lasts.
constexpr double taps = 9;
constexpr double blocks = 3;
constexpr double block_convs = 3;  ///< Of this frame; the frame before takes one more.
constexpr std::array<double, 3> grown_frames{1, 2, 2};

double latents_of(const ClipSize& clip) { return static_cast<double>(clip.height * clip.width) / (side * side); }

double number_bytes(VaePrecision precision) { return resolved(precision) == VaePrecision::bf16 ? 2 : 4; }

/// One level, from the frames that reach it to those it hands on at twice their size.
struct LevelSize {
  double channels = 0, next = 0;
  double grown = 1;   ///< Frames it makes of one.
  double frames = 1;  ///< That reach it, of a latent one.
  double pixels = 0;  ///< Of a frame that reaches it.

  double conv() const { return taps * channels * channels; }
};

std::array<LevelSize, 3> levels_of(const TinyVaeSizes& sizes, double latents) {
  std::array<LevelSize, 3> levels;
  double frames = 1, pixels = latents;
  for (std::size_t i = 0; i < levels.size(); ++i, pixels *= 4) {
    const std::int64_t next = i + 1 < levels.size() ? sizes.levels[i + 1] : sizes.last;
    levels[i] = {static_cast<double>(sizes.levels[i]), static_cast<double>(next), grown_frames[i], frames, pixels};
    frames *= grown_frames[i];
  }
  return levels;
}

}  // namespace

TinyVaeSizes TinyVaeSizes::read(const std::string& path) {
  const WeightFiles weights = WeightFiles::open(path);
  const auto results = [&](const char* name) { return weights.shape(name).front(); };
  return {weights.shape("decoder.1.weight").at(1),
          {results("decoder.1.weight"), results("decoder.8.weight"), results("decoder.14.weight")},
          results("decoder.20.weight")};
}

double estimated_flops(const TinyVaeSizes& sizes, const ClipSize& clip) {
  const double latents = latents_of(clip), count = 1 + static_cast<double>(clip.frames - 1) / latent_frames;
  const double first = static_cast<double>(sizes.levels[0]), last = static_cast<double>(sizes.last);
  // Multiplications, each with its addition.
  double each = taps * static_cast<double>(sizes.z_dim) * first * latents;
  double unseen = 0;  // The clip's first frame has none before it.
  for (const LevelSize& level : levels_of(sizes, latents)) {
    const double all = blocks * (block_convs + 1) * level.conv() + level.grown * level.channels * level.channels;
    each += level.frames * level.pixels * (all + level.grown * 4 * taps * level.channels * level.next);
    unseen += blocks * level.conv() * level.pixels;
  }
  each += latent_frames * taps * last * 3 * latents * side * side;
  return 2 * (count * each - unseen);
}

double estimated_weight_bytes(const TinyVaeSizes& sizes, VaePrecision precision) {
  double numbers = taps * static_cast<double>(sizes.z_dim * sizes.levels[0] + 3 * sizes.last);
  for (const LevelSize& level : levels_of(sizes, 0))
    numbers += blocks * (block_convs + 1) * level.conv() + level.grown * level.channels * level.channels +
               taps * level.channels * level.next;
  return numbers * number_bytes(precision);
}

double estimated_working_bytes(const TinyVaeSizes& sizes, const ClipSize& clip, VaePrecision precision) {
  double remembered = 0, most = 0;
  double waiting = 0;  // Of the levels before, until all that follows from it is done.
  for (const LevelSize& level : levels_of(sizes, latents_of(clip))) {
    const double frame = level.channels * level.pixels;
    remembered += blocks * frame;
    // What a block was given, what its convolution reads and what that gives.
    most = std::max(most, waiting + 3 * frame);
    // The frame, the frames made of it, and one of these at twice its size.
    waiting += (1 + level.grown + 4) * frame;
    most = std::max(most, waiting + (level.next + 3) * 4 * level.pixels);
  }
  return (remembered + most) * number_bytes(precision);
}

double estimated_peak_bytes(const TinyVaeSizes& sizes, const ClipSize& clip, VaePrecision precision) {
  return program_bytes + estimated_weight_bytes(sizes, precision) + estimated_working_bytes(sizes, clip, precision);
}

}  // namespace uwv::model
