// SPDX-License-Identifier: Apache-2.0
// Writes .safetensors files, tensor by tensor, so that a file larger than memory can be made. The layout is told in
// safetensors.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "uwv/io/safetensors.h"

namespace uwv {

/// What a file will hold: names with types and shapes.
using TensorInfos = std::map<std::string, TensorInfo>;

/// A file being written. It appears under its name only with commit(); without, nothing is left behind. Throws
/// Error(output_failed) when the disk refuses, std::invalid_argument for the caller's mistakes named below.
class SafeTensorsWriter {
 public:
  /// The header is written at once. Tensors are laid out by falling size of their numbers, then by name, so that each
  /// is aligned to its own type. No name may be empty or "__metadata__", no shape may overflow 64 bits.
  SafeTensorsWriter(const std::string& path, const TensorInfos& tensors,
                    const std::map<std::string, std::string>& metadata = {});
  ~SafeTensorsWriter();
  SafeTensorsWriter(SafeTensorsWriter&&) noexcept;
  SafeTensorsWriter& operator=(SafeTensorsWriter&&) = delete;

  /// The next bytes of a tensor, row-major and little-endian: all of it or a piece. Tensors may come in any order, and
  /// pieces of several in turn. Refused are unknown names and more bytes than the tensor has.
  void append(const std::string& name, std::span<const std::byte> bytes);
  /// Finishes the file. Refused while any tensor lacks bytes, naming it.
  void commit();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A tensor at hand, to be written whole.
struct TensorBytes {
  TensorInfo info;
  std::span<const std::byte> bytes;
};

/// Writes a file of tensors that are at hand. Throws as SafeTensorsWriter does.
void write_safetensors(const std::string& path, const std::map<std::string, TensorBytes>& tensors,
                       const std::map<std::string, std::string>& metadata = {});

}  // namespace uwv
