// SPDX-License-Identifier: Apache-2.0
// Token ids against transformers', for every case of every tokenizer folder among the fixtures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "model/text/tokenizer.h"
#include "support/matchers.h"
#include "support/temp_folder.h"

namespace uwv::model {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::vector<fs::path> tokenizer_folders() {
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(testing::fixture_folder("text")))
    if (fs::exists(entry.path() / "cases.json")) folders.push_back(entry.path());
  return folders;
}

json cases_of(const fs::path& folder) { return json::parse(std::ifstream(folder / "cases.json")); }

void expect_cases(const Tokenizer& tokenizer, const json& golden) {
  for (const json& c : golden.at("cases")) {
    const auto text = c.at("text").get<std::string>();
    const Tokens tokens = tokenizer.encode(text, c.at("max_length").get<std::size_t>());
    EXPECT_EQ(tokens.ids, c.at("input_ids").get<std::vector<std::int64_t>>()) << text;
    EXPECT_EQ(tokens.mask, c.at("attention_mask").get<std::vector<std::int64_t>>()) << text;
  }
  for (const json& c : golden.at("untruncated"))
    EXPECT_EQ(tokenizer.encode(c.at("text").get<std::string>()), c.at("hf_full").get<std::vector<std::int64_t>>())
        << c.at("text");
  EXPECT_EQ(tokenizer.ids(), golden.at("len_tokenizer").get<std::int64_t>());
}

TEST(TokenizerParity, IdsAreThoseOfTransformers) {
  ASSERT_FALSE(tokenizer_folders().empty());
  for (const fs::path& folder : tokenizer_folders()) {
    SCOPED_TRACE(folder.filename());
    expect_cases(Tokenizer::open(folder.string()), cases_of(folder));
  }
}

TEST(TokenizerParity, TheSentencePieceModelAloneGivesTheSameIds) {
  for (const fs::path& folder : tokenizer_folders()) {
    SCOPED_TRACE(folder.filename());
    const test::TempFolder without_json;
    for (const char* name : {"spiece.model", "tokenizer_config.json"})
      fs::copy_file(folder / name, without_json.path() / name);
    expect_cases(Tokenizer::open(without_json.path().string()), cases_of(folder));
  }
}

}  // namespace
}  // namespace uwv::model
