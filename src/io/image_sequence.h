// SPDX-License-Identifier: Apache-2.0
// Pictures in files as the frames of a clip.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "uwv/io/frame_source.h"

namespace uwv {

/// Whether `a` comes before `b` when runs of digits count as numbers: frame2 < frame10.
bool natural_less(const std::string& a, const std::string& b);

/// Paths of the pictures in a folder, in natural order. Throws Error(format_unknown) when there are none.
std::vector<std::string> pictures_in_folder(const std::string& folder);

/// Paths of the files whose name matches the pattern's last part: `%d`, `%5d`, `%05d` in order of the number, or `*`
/// and
/// `?` in natural order. Nothing when the name holds neither. Throws Error(file_not_found) when no file matches.
std::optional<std::vector<std::string>> files_matching(const std::string& pattern);

std::unique_ptr<FrameSource> open_pictures(const std::string& path, std::vector<std::string> files,
                                           const ClipOptions& options);

}  // namespace uwv
