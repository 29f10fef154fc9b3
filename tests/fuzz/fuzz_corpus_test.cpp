// SPDX-License-Identifier: Apache-2.0
// Readers against the corpus of the fuzzers and damage done to it: they load or refuse, and never do anything else.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>

#include "fuzz/fuzz_inputs.h"
#include "uwv/core/error.h"

namespace uwv::testing {
namespace {

namespace fs = std::filesystem;

class FuzzCorpus : public ::testing::TestWithParam<FuzzInput> {
 protected:
  /// True when the reader took the bytes.
  bool run(const std::string& bytes, const std::string& what) const {
    try {
      GetParam().run(bytes);
      return true;
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << what << ": " << error.what();
    } catch (const std::exception& error) {
      ADD_FAILURE() << what << ": " << error.what();
    }
    return false;
  }

  /// File names and contents, by name.
  static std::vector<std::pair<std::string, std::string>> corpus(const std::string& input) {
    std::vector<std::pair<std::string, std::string>> files;
    for (const auto& entry : fs::directory_iterator(fs::path(UWV_TEST_DATA) / "fuzz" / input)) {
      std::ifstream in(entry.path(), std::ios::binary);
      files.emplace_back(entry.path().filename().string(), std::string(std::istreambuf_iterator<char>(in), {}));
    }
    std::sort(files.begin(), files.end());
    return files;
  }
};

TEST_P(FuzzCorpus, IsReadOrRefused) {
  int taken = 0;
  const auto files = corpus(GetParam().name);
  ASSERT_FALSE(files.empty());
  for (const auto& [name, bytes] : files) taken += run(bytes, name);
  // The corpus begins with files that are right.
  EXPECT_GT(taken, 0);
}

TEST_P(FuzzCorpus, IsReadOrRefusedCutAtEveryLength) {
  // Long files would make the test slow: of those, as many lengths evenly spread.
  constexpr std::size_t most_lengths = 400;
  for (const auto& [name, bytes] : corpus(GetParam().name)) {
    const std::size_t step = std::max<std::size_t>(1, bytes.size() / most_lengths);
    for (std::size_t length = 0; length < bytes.size(); length += step)
      run(bytes.substr(0, length), fmt::format("{} cut to {}", name, length));
  }
}

TEST_P(FuzzCorpus, IsReadOrRefusedWithBitsFlipped) {
  constexpr int times = 100;
  std::mt19937 random(7);
  for (const auto& [name, bytes] : corpus(GetParam().name)) {
    for (int i = 0; i < times && !bytes.empty(); ++i) {
      std::string damaged = bytes;
      std::string what = fmt::format("{} with bits flipped:", name);
      for (auto flips = 1 + random() % 3; flips > 0; --flips) {
        const std::size_t bit = random() % (8 * damaged.size());
        damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
        what += fmt::format(" {}", bit);
      }
      run(damaged, what);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Readers, FuzzCorpus, ::testing::ValuesIn(fuzz_inputs()),
                         [](const auto& input) { return input.param.name; });

}  // namespace
}  // namespace uwv::testing
