// SPDX-License-Identifier: Apache-2.0
// Character references of HTML ("&amp;", "&#233;", "&#xE9;") replaced by what they stand for.
#pragma once

#include <string>
#include <string_view>

namespace uwv::model {

/// Which references are replaced.
enum class HtmlReferences {
  /// As HTML5 reads them: some names need no semicolon, and the longest name that fits counts. Python's html.unescape.
  all,
  /// Only those that end in a semicolon; names in capitals stand for the capital of what the small name means. For text
  /// that may not be HTML.
  closed,
};

/// `text` and the answer are UTF-8.
std::string unescape_html(std::string_view text, HtmlReferences references);

}  // namespace uwv::model
