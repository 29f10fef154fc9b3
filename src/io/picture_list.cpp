// SPDX-License-Identifier: Apache-2.0
// Which files make up a sequence of pictures, and in what order.
#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <string_view>

#include "io/image_sequence.h"

namespace uwv {
namespace {

namespace fs = std::filesystem;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

bool has_picture_extension(const std::string& name) {
  static constexpr std::array<std::string_view, 12> known{".png",  ".jpg", ".jpeg", ".bmp", ".tif", ".tiff",
                                                          ".webp", ".ppm", ".pgm",  ".pbm", ".pnm", ".jp2"};
  std::string extension = fs::path(name).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
  return std::find(known.begin(), known.end(), extension) != known.end();
}

// Names of the regular files in a folder; hidden ones (such as macOS's ._frame.png) left out.
std::vector<std::string> visible_files(const fs::path& folder) {
  std::error_code error;
  std::vector<std::string> names;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    const std::string name = it->path().filename().string();
    if (!name.empty() && name[0] != '.' && it->is_regular_file(ignored)) names.push_back(name);
  }
  if (error)
    fail(ErrorCode::file_not_found, "{}: cannot be listed ({}); a readable folder is wanted", folder.string(),
         error.message());
  return names;
}

// `*` is any run of characters, `?` any one character. Remembers only the last star, so it takes at most
// pattern-length times name-length steps.
bool matches_glob(std::string_view pattern, std::string_view name) {
  std::size_t p = 0, n = 0, star = std::string_view::npos, resume = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = n;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n])) {
      ++p;
      ++n;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      n = ++resume;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

// A file name around one printf-style number.
struct NumberPattern {
  std::string before, after;
  std::size_t digits = 0;  // at least this many

  static std::optional<NumberPattern> parse(const std::string& name) {
    const std::size_t percent = name.find('%');
    if (percent == std::string::npos) return std::nullopt;
    std::size_t end = percent + 1;
    while (end < name.size() && is_digit(name[end])) ++end;
    if (end >= name.size() || name[end] != 'd' || end - percent > 3) return std::nullopt;
    NumberPattern pattern{name.substr(0, percent), name.substr(end + 1)};
    std::from_chars(name.data() + percent + 1, name.data() + end, pattern.digits);
    return pattern;
  }

  bool matches(const std::string& name) const {
    if (name.size() <= before.size() + after.size()) return false;
    const std::size_t length = name.size() - before.size() - after.size();
    return name.starts_with(before) && name.ends_with(after) && length >= digits &&
           std::all_of(name.begin() + static_cast<std::ptrdiff_t>(before.size()),
                       name.end() - static_cast<std::ptrdiff_t>(after.size()), is_digit);
  }
};

std::vector<std::string> sorted_paths(const fs::path& folder, std::vector<std::string> names) {
  std::sort(names.begin(), names.end(), natural_less);
  for (std::string& name : names) name = (folder / name).string();
  return names;
}

}  // namespace

bool natural_less(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!is_digit(a[i]) || !is_digit(b[j])) {
      if (a[i] != b[j]) return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[j]);
      ++i;
      ++j;
      continue;
    }
    // Numbers of any length: without leading zeros the longer one is larger, equal lengths compare digit by digit.
    while (i < a.size() && a[i] == '0') ++i;
    while (j < b.size() && b[j] == '0') ++j;
    const auto run = [](const std::string& s, std::size_t from) {
      std::size_t to = from;
      while (to < s.size() && is_digit(s[to])) ++to;
      return std::string_view(s).substr(from, to - from);
    };
    const std::string_view x = run(a, i), y = run(b, j);
    if (x.size() != y.size()) return x.size() < y.size();
    if (x != y) return x < y;
    i += x.size();
    j += y.size();
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;  // equal but for leading zeros: still one fixed order
}

std::vector<std::string> pictures_in_folder(const std::string& folder) {
  std::vector<std::string> names = visible_files(folder);
  std::erase_if(names, [](const std::string& name) { return !has_picture_extension(name); });
  if (names.empty())
    fail(ErrorCode::format_unknown, "{}: this folder holds no pictures (.png, .jpg, .tif, .webp, .bmp, .ppm, ...)",
         folder);
  return sorted_paths(folder, std::move(names));
}

std::optional<std::vector<std::string>> files_matching(const std::string& pattern) {
  const fs::path whole(pattern);
  const std::string name = whole.filename().string();
  const std::optional<NumberPattern> numbered = NumberPattern::parse(name);
  if (!numbered && name.find_first_of("*?") == std::string::npos) return std::nullopt;
  const fs::path folder = whole.has_parent_path() ? whole.parent_path() : fs::path(".");
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored))
    fail(ErrorCode::file_not_found, "{}: there is no folder {}", pattern, folder.string());
  std::vector<std::string> names = visible_files(folder);
  std::erase_if(names, [&](const std::string& candidate) {
    return !(numbered ? numbered->matches(candidate) : matches_glob(name, candidate));
  });
  if (names.empty()) fail(ErrorCode::file_not_found, "{}: no file matches this pattern", pattern);
  return sorted_paths(folder, std::move(names));
}

}  // namespace uwv
