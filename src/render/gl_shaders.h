// SPDX-License-Identifier: Apache-2.0
// The text of the files in shaders/, embedded when the library is built (cmake/UwvEmbed.cmake).
#pragma once

#include <string_view>

namespace uwv {

/// Empty when there is no such file.
std::string_view shader_text(std::string_view file_name);

}  // namespace uwv
