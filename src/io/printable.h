// SPDX-License-Identifier: Apache-2.0
// Text from files made fit for an error sentence.
#pragma once

#include <string>
#include <string_view>

namespace uwv::io {

/// The text, at most 200 bytes of it, with control and non-ASCII characters replaced by '?', so that a hostile name can
/// neither break the line nor talk to the terminal.
inline std::string printable(std::string_view text) {
  std::string line(text.substr(0, 200));
  for (char& c : line)
    if (c < ' ' || c > '~') c = '?';
  return line;
}

}  // namespace uwv::io
