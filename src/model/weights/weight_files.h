// SPDX-License-Identifier: Apache-2.0
// A network's weights as tensors by name, out of one safetensors file or many. Sheet model.md, 1 ("Checkpoint").
//
// The files stay mapped: view() costs nothing, and what has been used can be given back to the page cache, so that a
// network larger than memory can be walked through block by block.
#pragma once

#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "uwv/io/safetensors.h"

namespace uwv::model {

/// What a network wants: names with shapes.
using TensorShapes = std::map<std::string, std::vector<std::int64_t>>;

/// A weight in 8-bit whole numbers: weight ~ numbers * the scale of their row.
struct QuantisedWeight {
  at::Tensor numbers;  ///< (out, in) int8
  at::Tensor scales;   ///< (out) float32
};

/// What the scales of a weight are stored as beside it: type F32, one a row.
inline std::string scales_name(const std::string& weight) { return weight + ".row_scales"; }

class WeightFiles {
 public:
  /// `path` is a safetensors file, or a folder with (in this order) an "*.safetensors.index.json" and its shards, a
  /// file "diffusion_pytorch_model.safetensors" or "model.safetensors", or any *.safetensors, which are merged. Throws
  /// Error: file_not_found; file_damaged (see SafeTensors, and an index that does not fit its shards, a name that two
  /// files hold); format_unknown for pickles (.pt .pth .bin .ckpt), which can run code when they are read, saying how
  /// to convert them.
  static WeightFiles open(const std::string& path);

  const std::string& path() const { return path_; }
  std::vector<std::string> names() const;
  bool has(const std::string& name) const { return entries_.contains(name); }
  /// Throws Error(value_invalid) naming the path, as all below do, when there is no such tensor.
  const TensorInfo& info(const std::string& name) const;
  std::vector<std::int64_t> shape(const std::string& name) const;
  /// Bytes of all tensors as stored.
  std::uint64_t bytes() const;

  /// Takes each name to what `rename` makes of it; an empty result leaves the tensor out. Throws Error(file_damaged)
  /// when two become one.
  void rename(const std::function<std::string(const std::string&)>& rename);

  /// Where view() and load() put tensors: the CPU, unless told otherwise. The files stay mapped into main memory.
  void put_on(c10::Device device) { device_ = device; }
  c10::Device device() const { return device_; }

  /// The stored numbers in their own type: on the CPU as mapped(), elsewhere a copy. Throws Error(value_invalid), as
  /// mapped() does, for a weight that is_quantised(): its numbers mean nothing without their scales.
  at::Tensor view(const std::string& name) const;
  /// The stored numbers on the CPU, without a copy where their alignment allows it. They are mapped read-only: writing
  /// to the tensor ends the program. Valid while any copy of this object lives.
  at::Tensor mapped(const std::string& name) const;
  /// Whether the weight has scales beside it, as `uwv_app model convert` writes them; and it, numbers as view() gives
  /// them. Valid after check().
  bool is_quantised(const std::string& name) const { return has(scales_name(name)); }
  QuantisedWeight quantised(const std::string& name) const;
  /// The numbers as `type`, in memory of their own.
  at::Tensor load(const std::string& name, at::ScalarType type) const;

  /// Tells the system that a tensor will soon be read, or that its pages may be dropped (they are read again when
  /// needed). Hints; they never fail.
  void will_need(const std::string& name) const;
  void release(const std::string& name) const;

  /// Throws Error(value_invalid) with every missing and every misshaped tensor named (at most ten of each, and how many
  /// more), and for weights that other programs quantised with scales beside them. Returns the names nobody wants.
  std::vector<std::string> check(const TensorShapes& wanted) const;

 private:
  struct Entry {
    std::size_t file = 0;
    std::string stored_name;
  };
  const Entry& entry(const std::string& name) const;
  at::Tensor stored(const std::string& name) const;
  std::string misfit(const std::string& name, const std::vector<std::int64_t>& wanted) const;
  void refuse_scaled() const;

  std::string path_;
  c10::Device device_ = c10::kCPU;
  std::vector<SafeTensors> files_;
  std::map<std::string, Entry> entries_;
};

}  // namespace uwv::model
