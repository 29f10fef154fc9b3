// SPDX-License-Identifier: Apache-2.0
#include "io/depth_array.h"

#include <algorithm>
#include <array>
#include <limits>

#include "io/depth_codecs.h"
#include "io/disk_file.h"
#include "io/printable.h"

namespace uwv::io {
namespace {

std::string choose_key(const std::string& path, const std::string& key) {
  if (!key.empty() || !is_npz(path)) return key;
  const auto names = npz_names(path);
  for (const char* usual : {"dep", "depth", "depths", "arr_0"})
    if (std::find(names.begin(), names.end(), usual) != names.end()) return usual;
  if (names.size() == 1) return names[0];
  fail(ErrorCode::value_invalid, "{}: has no array named dep, depth, depths or arr_0; choose a key of: {}", path,
       printable(fmt::format("{}", fmt::join(names, ", "))));
}

}  // namespace

bool is_numpy_file(const std::string& path) {
  const InputFile file(path);
  std::array<char, 6> start{};
  if (file.size() < start.size()) return false;
  file.read_at(0, std::as_writable_bytes(std::span(start)));
  return std::string_view(start.data(), start.size()) == "\x93NUMPY" || is_npz(path);
}

DepthArray::DepthArray(const std::string& path, const std::string& key) : reader_(path, choose_key(path, key)) {
  std::vector<std::size_t> shape = reader_.header().shape;
  if (shape.size() == 4 && shape[1] == 1)
    shape.erase(shape.begin() + 1);
  else if (shape.size() == 4 && shape[3] == 1)
    shape.pop_back();
  if (shape.size() == 2) shape.insert(shape.begin(), 1);
  if (shape.size() != 3 || shape[0] == 0 || shape[0] > std::numeric_limits<int>::max())
    fail(ErrorCode::value_invalid,
         "{}: an array of shape ({}) is no depth; (h, w), (n, h, w), (n, 1, h, w) or (n, h, w, 1) is wanted", path,
         fmt::join(reader_.header().shape, ", "));
  frames_ = static_cast<long>(shape[0]);
  size_ = checked_size(shape[2], shape[1], path);
}

void DepthArray::read(long index, double scale, DepthMap& out) {
  require(index >= 0 && index < frames_, "depth frame {} of {} was asked for", index, frames_);
  out.resize(size_);
  reader_.read(static_cast<std::size_t>(index), out.pixels());
  if (scale != 1)
    for (float& z : out.pixels()) z = static_cast<float>(z * scale);
}

}  // namespace uwv::io
