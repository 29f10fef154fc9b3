// SPDX-License-Identifier: Apache-2.0
#include "uwv/io/safetensors_writer.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "io/disk_file.h"
#include "uwv/core/error.h"

namespace uwv {
namespace {

/// Where a tensor's bytes go, and how many have come.
struct Place {
  std::uint64_t begin = 0, bytes = 0, written = 0;
};

std::uint64_t bytes_of(const TensorInfo& info, const std::string& name) {
  std::uint64_t total = size_of(info.dtype);
  for (const std::size_t n : info.shape)
    require(!__builtin_mul_overflow(total, n, &total), "tensor '{}': its shape ({}) overflows 64 bits", name,
            fmt::join(info.shape, ", "));
  return total;
}

/// Offsets from the start of the data.
std::map<std::string, Place> lay_out(const TensorInfos& tensors) {
  std::vector<const TensorInfos::value_type*> order;
  for (const auto& entry : tensors) order.push_back(&entry);
  std::stable_sort(order.begin(), order.end(),
                   [](const auto* a, const auto* b) { return size_of(a->second.dtype) > size_of(b->second.dtype); });
  std::map<std::string, Place> places;
  std::uint64_t end = 0;
  for (const auto* entry : order) {
    const Place place{end, bytes_of(entry->second, entry->first), 0};
    require(!__builtin_add_overflow(end, place.bytes, &end), "tensor '{}': the file would overflow 64 bits",
            entry->first);
    places.emplace(entry->first, place);
  }
  return places;
}

std::string header_text(const TensorInfos& tensors, const std::map<std::string, Place>& places,
                        const std::map<std::string, std::string>& metadata) {
  nlohmann::json header = nlohmann::json::object();
  if (!metadata.empty()) header["__metadata__"] = metadata;
  for (const auto& [name, info] : tensors) {
    require(!name.empty() && name != "__metadata__", "a tensor cannot be named '{}'", name);
    const Place& place = places.at(name);
    header[name] = {{"dtype", std::string(to_string(info.dtype))},
                    {"shape", info.shape},
                    {"data_offsets", {place.begin, place.begin + place.bytes}}};
  }
  std::string text = header.dump(-1, ' ', /*ensure_ascii=*/false, nlohmann::json::error_handler_t::strict);
  // The data begins at a multiple of 8, which aligns every type there is.
  text.append((8 - text.size() % 8) % 8, ' ');
  return text;
}

}  // namespace

struct SafeTensorsWriter::State {
  explicit State(const std::string& path) : file(path) {}

  io::OutputFile file;
  std::uint64_t data_offset = 0;
  std::map<std::string, Place> places;
};

SafeTensorsWriter::SafeTensorsWriter(const std::string& path, const TensorInfos& tensors,
                                     const std::map<std::string, std::string>& metadata) {
  std::map<std::string, Place> places = lay_out(tensors);
  const std::string header = header_text(tensors, places, metadata);
  state_ = std::make_unique<State>(path);
  const std::uint64_t header_bytes = header.size();
  state_->file.append(std::as_bytes(std::span(&header_bytes, 1)));
  state_->file.append(header);
  state_->data_offset = state_->file.position();
  std::uint64_t data_bytes = 0;
  for (const auto& [name, place] : places) data_bytes = std::max(data_bytes, place.begin + place.bytes);
  state_->file.extend(data_bytes);
  state_->places = std::move(places);
}

SafeTensorsWriter::~SafeTensorsWriter() = default;
SafeTensorsWriter::SafeTensorsWriter(SafeTensorsWriter&&) noexcept = default;

void SafeTensorsWriter::append(const std::string& name, std::span<const std::byte> bytes) {
  const auto found = state_->places.find(name);
  require(found != state_->places.end(), "{}: was not announced to hold a tensor '{}'", state_->file.path(), name);
  Place& place = found->second;
  require(bytes.size() <= place.bytes - place.written, "{}: tensor '{}' has {} bytes, {} more than {} came",
          state_->file.path(), name, place.bytes, bytes.size(), place.written);
  state_->file.patch(state_->data_offset + place.begin + place.written, bytes);
  place.written += bytes.size();
}

void SafeTensorsWriter::commit() {
  for (const auto& [name, place] : state_->places)
    require(place.written == place.bytes, "{}: {} of the {} bytes of tensor '{}' came", state_->file.path(),
            place.written, place.bytes, name);
  state_->file.commit();
}

void write_safetensors(const std::string& path, const std::map<std::string, TensorBytes>& tensors,
                       const std::map<std::string, std::string>& metadata) {
  TensorInfos infos;
  for (const auto& [name, tensor] : tensors) infos.emplace(name, tensor.info);
  SafeTensorsWriter writer(path, infos, metadata);
  for (const auto& [name, tensor] : tensors) writer.append(name, tensor.bytes);
  writer.commit();
}

}  // namespace uwv
