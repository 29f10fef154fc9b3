// SPDX-License-Identifier: Apache-2.0
#include "model/text/prompt_cache.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "model/layers/torch_scope.h"
#include "model/tensor_support.h"
#include "support/matchers.h"
#include "support/temp_folder.h"

namespace uwv::model {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;
using uwv::testing::near;

constexpr std::int64_t tokens = 40;

/// Counts the layers the encoder walks through: none when all comes from the cache.
class CountingMonitor : public Monitor {
 public:
  bool progress(std::string_view, long, long) override {
    ++steps;
    return true;
  }
  void warn(const std::string& sentence) override { warning = sentence; }
  int steps = 0;
  std::string warning;
};

PromptEncoding tiny_encoding() {
  const std::string text = testing::fixture_folder("text");
  return {text + "/text_encoder", text + "/tokenizer", LinearForm::f32, tokens};
}

TEST(PromptCache, TheEncoderRunsOnceForAPrompt) {
  const TorchScope scope(1);
  const TempFolder folder;
  const PromptCache cache(folder.file("made/when/needed"));
  CountingMonitor first, again, partly;
  const auto encoded = encode_prompts({"a white rabbit", ""}, tiny_encoding(), cache, first);
  EXPECT_GT(first.steps, 0);
  const auto cached = encode_prompts({" a white\n rabbit ", ""}, tiny_encoding(), cache, again);
  EXPECT_EQ(again.steps, 0);
  ASSERT_EQ(cached.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(encoded[i].size(1), tokens);
    EXPECT_TRUE(at::equal(encoded[i], cached[i]));
  }
  EXPECT_FALSE(at::equal(encoded[0], encoded[1]));
  const auto mixed = encode_prompts({"another", "a white rabbit"}, tiny_encoding(), cache, partly);
  EXPECT_GT(partly.steps, 0);
  EXPECT_TRUE(at::equal(mixed[1], encoded[0]));
}

TEST(PromptCache, WhatChangesTheAnswerChangesTheRecipe) {
  const PromptEncoding encoding = tiny_encoding();
  PromptEncoding shorter = encoding, rounded = encoding, other_tokenizer = encoding, other_weights = encoding;
  shorter.tokens = 20;
  rounded.form = LinearForm::bf16;
  other_tokenizer.tokenizer_folder = testing::fixture_folder("text/tokenizer_bytes");
  other_weights.encoder_folder = testing::fixture_folder("text/text_encoder_sharded");
  for (const PromptEncoding& other : {shorter, rounded, other_tokenizer, other_weights})
    EXPECT_NE(other.recipe("a"), encoding.recipe("a"));
  EXPECT_NE(encoding.recipe("a"), encoding.recipe("b"));
  EXPECT_EQ(encoding.recipe("a"), encoding.recipe("a"));
}

TEST(PromptCache, ADamagedEntryIsMadeAnew) {
  const TorchScope scope(1);
  const TempFolder folder;
  const PromptCache cache(folder.path().string());
  CountingMonitor monitor;
  const auto right = encode_prompts({"a cat"}, tiny_encoding(), cache, monitor);
  const std::string entry = cache.path_of(tiny_encoding().recipe("a cat"));
  ASSERT_TRUE(fs::exists(entry));
  const std::string whole = folder.read(fs::path(entry).filename().string());
  for (const std::size_t length : {std::size_t{0}, std::size_t{4}, whole.size() / 2, whole.size() - 1}) {
    testing::write_text(entry, whole.substr(0, length));
    monitor.steps = 0;
    EXPECT_TRUE(at::equal(encode_prompts({"a cat"}, tiny_encoding(), cache, monitor)[0], right[0]));
    EXPECT_GT(monitor.steps, 0) << length;
    EXPECT_EQ(fs::file_size(entry), whole.size());
  }
}

TEST(PromptCache, AnEntryOfAnotherPromptOrShapeIsNotTaken) {
  const TempFolder folder;
  const PromptCache cache(folder.path().string());
  cache.store("one", at::ones({1, 3, 2}));
  EXPECT_TRUE(cache.find("one", 3).has_value());
  EXPECT_FALSE(cache.find("one", 4).has_value());
  fs::copy_file(cache.path_of("one"), cache.path_of("two"));
  EXPECT_FALSE(cache.find("two", 3).has_value());
  cache.store("broken", at::full({1, 3, 2}, NAN));
  EXPECT_FALSE(cache.find("broken", 3).has_value());
}

TEST(PromptCache, AFolderThatCannotBeWrittenIsAWarning) {
  const TorchScope scope(1);
  const TempFolder folder;
  testing::write_text(folder.file("file"), "in the way");
  CountingMonitor monitor;
  EXPECT_EQ(encode_prompts({"a"}, tiny_encoding(), PromptCache(folder.file("file/below")), monitor).size(), 1U);
  EXPECT_THAT(monitor.warning, ::testing::HasSubstr("not kept"));
  monitor.warning.clear();
  EXPECT_EQ(encode_prompts({"a"}, tiny_encoding(), PromptCache(""), monitor).size(), 1U);
  EXPECT_EQ(monitor.warning, "");
}

}  // namespace
}  // namespace uwv::model
