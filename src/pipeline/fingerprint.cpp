// SPDX-License-Identifier: Apache-2.0
#include "pipeline/fingerprint.h"

extern "C" {
#include <libavutil/mem.h>
#include <libavutil/sha.h>
}

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <new>
#include <vector>

namespace uwv::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t sample_bytes = std::uintmax_t{64} * 1024;

std::int64_t modified(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return 0;
  return std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec;
}

std::string both_ends(const fs::path& path, std::uintmax_t size) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes(std::min(size, 2 * sample_bytes), '\0');
  const auto head = static_cast<std::streamsize>(std::min<std::uintmax_t>(bytes.size(), sample_bytes));
  const auto tail = static_cast<std::streamsize>(bytes.size()) - head;
  file.read(bytes.data(), head);
  file.seekg(-static_cast<std::streamoff>(tail), std::ios::end);
  file.read(bytes.data() + head, tail);
  return bytes;
}

template <class Entries>
nlohmann::ordered_json identity_of_entries(const fs::path& folder, Entries entries) {
  std::vector<std::string> lines;
  std::uintmax_t bytes = 0;
  std::int64_t newest = 0;
  for (const fs::directory_entry& entry : entries) {
    if (!entry.is_regular_file()) continue;
    bytes += entry.file_size();
    newest = std::max(newest, modified(entry.path()));
    lines.push_back(entry.path().lexically_relative(folder).string() + '\0' + std::to_string(entry.file_size()) + '\0' +
                    std::to_string(modified(entry.path())));
  }
  std::sort(lines.begin(), lines.end());
  std::string all;
  for (const std::string& line : lines) all += line + '\n';
  return {{"bytes", bytes}, {"modified", newest}, {"files", lines.size()}, {"sha256", sha256(all)}};
}

nlohmann::ordered_json identity_of_folder(const fs::path& folder) {
  return identity_of_entries(folder, fs::directory_iterator(folder));
}

}  // namespace

std::string sha256(std::string_view bytes) {
  const std::unique_ptr<AVSHA, void (*)(void*)> state(av_sha_alloc(), av_free);
  if (!state) throw std::bad_alloc();
  av_sha_init(state.get(), 256);
  av_sha_update(state.get(), reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  std::array<std::uint8_t, 32> digest{};
  av_sha_final(state.get(), digest.data());
  std::string text;
  for (const std::uint8_t byte : digest) {
    constexpr std::string_view digits = "0123456789abcdef";
    text += {digits[byte >> 4U], digits[byte & 15U]};
  }
  return text;
}

nlohmann::ordered_json input_identity(const std::string& name) {
  const fs::path path(name);
  if (fs::is_regular_file(path)) {
    const std::uintmax_t size = fs::file_size(path);
    return {{"bytes", size}, {"modified", modified(path)}, {"files", 1}, {"sha256", sha256(both_ends(path, size))}};
  }
  if (fs::is_directory(path)) return identity_of_folder(path);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (fs::is_directory(folder)) return identity_of_folder(folder);  // a pattern
  return nullptr;
}

nlohmann::ordered_json checkpoint_identity(const std::string& path) {
  if (fs::is_directory(path)) return identity_of_entries(path, fs::recursive_directory_iterator(path));
  return input_identity(path);
}

}  // namespace uwv::pipeline
