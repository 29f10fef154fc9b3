// SPDX-License-Identifier: Apache-2.0
// Small clips with holes, completed by the tiny model of the fixtures.
#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <string>
#include <vector>

#include "model/complaint.h"
#include "support/matchers.h"
#include "support/temp_folder.h"
#include "uwv/model/view_completion.h"

namespace uwv {

enum class Holes { none, right_half, all };

/// A pattern that moves, with holes.
struct Scene {
  Size size{48, 32};
  long frames = 5;
  Holes holes = Holes::right_half;
  bool photo = false;

  ImageRgb picture(long k) const {
    ImageRgb picture(size);
    for (int y = 0; y < size.height; ++y)
      for (int x = 0; x < size.width; ++x)
        picture(x, y) = {static_cast<std::uint8_t>(128 + 100 * std::sin(0.3 * x + 0.2 * static_cast<double>(k))),
                         static_cast<std::uint8_t>(6 * y % 256), static_cast<std::uint8_t>(4 * (x + y) % 256)};
    return picture;
  }
  RenderedClip clip() const {
    RenderedClip clip;
    clip.size = size;
    clip.frames = frames;
    clip.read = [this](long k, ImageRgb& colour, GenerateMask& mask) {
      colour = picture(k);
      mask = GenerateMask(size.width, size.height);
      for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x)
          mask(x, y) = holes == Holes::all || (holes == Holes::right_half && k > 0 && x > size.width / 2) ? 1 : 0;
    };
    if (!photo) clip.read_source = [this](long k, ImageRgb& colour) { colour = picture(k); };
    return clip;
  }
};

struct Answer {
  std::vector<ImageRgb> frames;
  CompletionSummary summary;
  int previews = 0;
  ImageRgb last_preview;
};

class CompletionTest : public ::testing::Test {
 protected:
  CompletionTest() {
    const std::string root = uwv::testing::fixture_folder("pipeline");
    options_.model = root + "/wan";
    options_.transformer = root + "/uniview";
    options_.steps = 2;
    options_.prompt_cache = cache_.file("prompts");
    options_.prompt = "a white rabbit";
  }
  Answer complete(const Scene& scene) { return complete(scene, options_); }
  Answer complete(const Scene& scene, const ModelOptions& options, int threads = 1) {
    Answer answer;
    CompletedClip out;
    out.write = [&](long k, const ImageRgb& picture) {
      EXPECT_EQ(k, static_cast<long>(answer.frames.size()));
      EXPECT_EQ(picture.size(), scene.size);
      answer.frames.push_back(picture);
    };
    out.preview = [&](const ImageRgb& picture) {
      ++answer.previews;
      answer.last_preview = picture;
    };
    answer.summary = complete_views(options, scene.clip(), out, threads, monitor_);
    EXPECT_EQ(static_cast<long>(answer.frames.size()), scene.frames);
    return answer;
  }
  std::string complaint(const ModelOptions& options) {
    return uwv::testing::complaint([&] { complete({}, options); });
  }

  test::TempFolder cache_;
  ModelOptions options_;
  Monitor monitor_;
};

/// The largest difference of any channel, and the mean one, of two clips of the same size.
struct Difference {
  int largest = 0;
  double mean = 0;
};

inline Difference difference(const std::vector<ImageRgb>& a, const std::vector<ImageRgb>& b) {
  Difference found;
  double sum = 0, count = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    for (std::size_t i = 0; i < a[k].size().pixels(); ++i) {
      const Rgb8 p = a[k].data()[i], q = b.at(k).data()[i];
      for (const int apart : {std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)}) {
        found.largest = std::max(found.largest, apart);
        sum += apart;
        ++count;
      }
    }
  found.mean = count > 0 ? sum / count : 0;
  return found;
}

}  // namespace uwv
