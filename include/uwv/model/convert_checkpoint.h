// SPDX-License-Identifier: Apache-2.0
// Writes a checkpoint anew with its layers' weights in fewer bits, so that it takes less disk, and less reading where
// the transformer is streamed. docs/model-transformer.md tells what is stored how.
#pragma once

#include <cstdint>
#include <string>

#include "uwv/core/monitor.h"

namespace uwv {

struct ConversionOptions {
  std::string model;             ///< Folder of the checkpoint, or of its transformer alone.
  std::string weights = "int8";  ///< "bf16", or "int8" with a scale an output channel.
  std::string out;               ///< Folder to make. It must not exist, nor lie within `model`.

  /// Throws std::invalid_argument.
  void check() const;
};

struct ConversionSummary {
  long rounded = 0, kept = 0;  ///< Tensors.
  std::uint64_t bytes_before = 0, bytes_after = 0;
  /// "12 tensors rounded, 3 kept: 8.59 GB became 2.20 GB".
  std::string brief() const;
};

/// Same layout, names of diffusers'; a tensor at a time. What is no transformer and no text encoder is copied. Until it
/// is done all goes to a folder beside `out`, of which nothing is left when it fails. Throws Error naming the file or
/// option; cancelled when the monitor stops it.
ConversionSummary convert_checkpoint(const ConversionOptions& options, Monitor& monitor);

}  // namespace uwv
