// SPDX-License-Identifier: Apache-2.0
// Repairs text that was UTF-8 and was read as another encoding: "cafÃ©" for "café", "donâ€™t" for "don’t".
#pragma once

#include <string>
#include <string_view>

namespace uwv::model {

/// Undoes readings as Latin-1, Windows-1252 and Windows-1251, also several in a row, of the whole line or of pieces of
/// it; and C1 control characters, which were meant as Windows-1252's. Sequences that honest text is likely to hold (a
/// capital letter before a closing quote) are left alone.
std::u32string repair_mojibake(std::u32string_view line);

}  // namespace uwv::model
