// SPDX-License-Identifier: Apache-2.0
// What the official pipeline does to a prompt before it is tokenized. Sheet model.md, 4 ("Prompt").
#pragma once

#include <string>
#include <string_view>

namespace uwv::model {

/// Repairs text that was decoded wrongly, unescapes HTML twice, and leaves one space between words and none at the
/// ends. The repair stands for that of Python's ftfy: HTML references of lines without "<"; UTF-8 read as
/// Latin-1, Windows-1252 or 1251; ligatures, full-width and half-width forms and curly quotes made plain; line ends;
/// terminal codes and control characters taken out; normalization form C. Rarer confusions that ftfy knows (Mac Roman,
/// code page 437, Central European, Greek and Turkish Windows) are left as they are. Broken UTF-8 becomes U+FFFD.
std::string clean_prompt(std::string_view prompt);

}  // namespace uwv::model
