// SPDX-License-Identifier: Apache-2.0
#include "model/text/prompt_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "model/text/html_text.h"
#include "model/text/unicode.h"
#include "model/text/utf8.h"
#include "support/matchers.h"

namespace uwv::model {
namespace {

TEST(PromptTextParity, CleansAsTheOfficialPipeline) {
  int cases = 0;
  for (const auto& entry : std::filesystem::directory_iterator(testing::fixture_folder("text"))) {
    std::ifstream file(entry.path() / "cases.json");
    if (!file) continue;
    const auto golden = nlohmann::json::parse(file);
    for (const auto& c : golden.at("prompt_clean")) {
      EXPECT_EQ(clean_prompt(c.at("in").get<std::string>()), c.at("out").get<std::string>()) << c.at("in");
      ++cases;
    }
  }
  EXPECT_GT(cases, 0);
}

// What ftfy 6.3.1 and Python's html make of these, after the pipeline's own steps.
TEST(PromptText, RepairsTextThatWasReadAsAnotherEncoding) {
  EXPECT_EQ(clean_prompt("caf\u00C3\u00A9 na\u00C3\u00AFve"), "caf\u00E9 na\u00EFve");
  EXPECT_EQ(clean_prompt("don\u00E2\u20AC\u2122t"), "don't");
  EXPECT_EQ(clean_prompt("\u00C3\u0192\u00C2\u00A9t\u00C3\u0192\u00C2\u00A9"), "\u00E9t\u00E9");
  EXPECT_EQ(clean_prompt("voil\u00C3 le travail"), "voil\u00E0 le travail");
  EXPECT_EQ(clean_prompt("\u6771\u4EAC and caf\u00C3\u00A9"), "\u6771\u4EAC and caf\u00E9");
  EXPECT_EQ(clean_prompt("\u0420\u045A\u0420\u0455\u0421\u0403\u0420\u0454"), "\u041C\u043E\u0441\u043A");
}

TEST(PromptText, LeavesHonestTextAlone) {
  for (const std::string text : {"Spa\u00DF\u2026", "CAF\u00C9\u2122 \u2014 10 \u00A3", "\u00E0 la carte",
                                 "caf\u00E9\u2014bar", "\u041C\u043E\u0441\u043A\u0432\u0430", "\u00C9\u2026",
                                 "\U0001F680\u200D\U0001F600", "\u0928\u092E\u0938\u094D\u0924\u0947"})
    EXPECT_EQ(clean_prompt(text), text);
}

TEST(PromptText, SpacesLinesAndUnseenCharactersGo) {
  EXPECT_EQ(clean_prompt(" a\r\nb\u2028 c\u00A0\u3000d\t"), "a b c d");
  EXPECT_EQ(clean_prompt("a\x1B[31mred\x1B[0m\uFEFF\x07"
                         "b"),
            "aredb");
  EXPECT_EQ(clean_prompt(std::string("a\0b", 3)), "ab");
  EXPECT_EQ(clean_prompt("e\u0301"), "\u00E9");
  EXPECT_EQ(clean_prompt(""), "");
  EXPECT_EQ(clean_prompt(" \n\t "), "");
}

TEST(PromptText, BrokenBytesBecomeReplacementCharacters) {
  EXPECT_EQ(clean_prompt("a\xFF"
                         "b"),
            "a\uFFFDb");
  EXPECT_EQ(clean_prompt("a\xE2\x82"), "a\uFFFD");
  EXPECT_EQ(clean_prompt("\xED\xA0\x80"), "\uFFFD\uFFFD\uFFFD");  // a surrogate
  EXPECT_EQ(clean_prompt("\xF4\x90\x80\x80"), "\uFFFD\uFFFD\uFFFD\uFFFD");
}

TEST(PromptText, ALongPromptTakesTimeInProportion) {
  std::string prompt;
  while (prompt.size() < 1'000'000) prompt += "caf\u00C3\u00A9 &amp; <b> \u201Cquoted\u201D ";
  const std::string cleaned = clean_prompt(prompt);
  EXPECT_TRUE(cleaned.starts_with("caf\u00E9 & <b> \"quoted\" caf\u00E9"));
}

TEST(HtmlText, ReferencesAreReadAsPythonReadsThem) {
  const auto all = [](std::string_view text) { return unescape_html(text, HtmlReferences::all); };
  EXPECT_EQ(all("&lt;&#233;&#xE9&eacute;&#128;&#0;&#xD800;&#7;"), "<\u00E9\u00E9\u00E9\u20AC\uFFFD\uFFFD");
  EXPECT_EQ(all("&notit; &notin; &copy2 &bogus; & &#; &#x;"), "\u00ACit; \u2209 \u00A92 &bogus; & &#; &#x;");
  EXPECT_EQ(all("&#99999999999999999999;"), "\uFFFD");
  EXPECT_EQ(all("&NotEqualTilde;"), "\u2242\u0338");
  const auto closed = [](std::string_view text) { return unescape_html(text, HtmlReferences::closed); };
  EXPECT_EQ(closed("&lt &lt; &NTILDE; &copy2 &#233 &#233; &notit;"), "&lt < \u00D1 &copy2 &#233 \u00E9 &notit;");
}

TEST(Unicode, ComposesMarksInAnyOrder) {
  EXPECT_EQ(nfc(U"a\u0323\u0302"), U"\u1EAD");
  EXPECT_EQ(nfc(U"a\u0302\u0323"), U"\u1EAD");
  EXPECT_EQ(nfc(U"\u1100\u1161\u11A8"), U"\uAC01");
  EXPECT_EQ(nfc(U"\u212B"), U"\u00C5");
  EXPECT_EQ(nfc(U"\u0958"), U"\u0915\u093C");  // excluded from composition
  EXPECT_EQ(nfc(U"\u0301a"), U"\u0301a");
}

}  // namespace
}  // namespace uwv::model
