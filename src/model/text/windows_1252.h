// SPDX-License-Identifier: Apache-2.0
// Windows-1252 and 1251: what programs take text for that is UTF-8. Bytes they leave undefined stand for the control
// character of the same number.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace uwv::model {

/// `byte` is 0 to 255.
char32_t from_windows_1252(std::uint32_t byte);
std::optional<unsigned char> to_windows_1252(char32_t c);
std::optional<unsigned char> to_windows_1251(char32_t c);
/// Latin-1's letters in capitals, all else as it is; UTF-8 in and out.
std::string capital_letters(std::string_view text);

}  // namespace uwv::model
