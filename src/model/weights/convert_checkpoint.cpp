// SPDX-License-Identifier: Apache-2.0
#include "uwv/model/convert_checkpoint.h"

#include <ATen/ATen.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "io/disk_file.h"
#include "model/layers/linear.h"
#include "model/layers/torch_scope.h"
#include "model/text/umt5_encoder.h"
#include "model/weights/wan_names.h"
#include "uwv/io/safetensors_writer.h"

namespace uwv {
namespace {

using namespace model;
namespace fs = std::filesystem;

constexpr std::uint64_t shard_bytes = 5'000'000'000;

/// A folder that becomes `path` when all is done, and is gone otherwise.
class NewFolder {
 public:
  explicit NewFolder(fs::path path) : path_(std::move(path)), part_(path_.string() + ".part") {
    for (const fs::path& taken : {path_, part_})
      if (fs::exists(taken))
        fail(ErrorCode::output_failed, "--out {}: is there already; remove it or name another folder", taken.string());
    std::error_code problem;
    fs::create_directories(part_, problem);
    if (problem) fail(ErrorCode::output_failed, "--out {}: cannot be made: {}", part_.string(), problem.message());
  }
  ~NewFolder() {
    std::error_code problem;
    if (!part_.empty()) fs::remove_all(part_, problem);
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  const fs::path& part() const { return part_; }
  void commit() {
    std::error_code problem;
    fs::rename(part_, path_, problem);
    if (problem) fail(ErrorCode::output_failed, "--out {}: cannot be named: {}", path_.string(), problem.message());
    part_.clear();
  }

 private:
  fs::path path_, part_;
};

bool starts_with_any(const std::string& name, std::initializer_list<const char*> starts) {
  for (const char* start : starts)
    if (name.starts_with(start)) return true;
  return false;
}

/// The matrices of the layers that a form is for: what the transformer and the text encoder multiply in it.
bool is_layer(const std::string& name, const TensorInfo& info) {
  return info.shape.size() == 2 && name.ends_with(".weight") && !name.ends_with("relative_attention_bias.weight") &&
         starts_with_any(name, {"blocks.", "vace_blocks.", "uniview_ref_attn.", "encoder.block."});
}

bool is_float(DType type) {
  return type == DType::f32 || type == DType::f16 || type == DType::bf16 || type == DType::f64;
}

/// One folder of weights on its way into another.
class WeightsConversion {
 public:
  WeightsConversion(const WeightFiles& from, bool int8, ConversionSummary& summary, Monitor& monitor)
      : from_(from), int8_(int8), summary_(summary), monitor_(monitor) {
    for (const std::string& name : from_.names())
      if (from_.is_quantised(name))
        fail(ErrorCode::value_invalid, "{}: is in 8 bits already; convert the checkpoint it was made of", from_.path());
  }

  void write(const fs::path& folder, const std::string& stem) {
    const std::vector<Shard> shards = lay_out();
    nlohmann::ordered_json index{{"metadata", nlohmann::ordered_json::object()},
                                 {"weight_map", nlohmann::ordered_json::object()}};
    for (std::size_t i = 0; i < shards.size(); ++i) {
      const std::string file = shards.size() == 1
                                   ? stem + ".safetensors"
                                   : fmt::format("{}-{:05}-of-{:05}.safetensors", stem, i + 1, shards.size());
      write_shard(folder / file, shards[i]);
      for (const auto& [name, info] : shards[i].infos) index["weight_map"][name] = file;
    }
    if (shards.size() == 1) return;
    io::OutputFile text((folder / (stem + ".safetensors.index.json")).string());
    text.append(index.dump(2));
    text.commit();
  }

 private:
  struct Shard {
    std::vector<std::string> names;  ///< Of tensors that are read.
    TensorInfos infos;               ///< Of all that are written.
  };

  bool is_rounded(const std::string& name) const {
    const TensorInfo& info = from_.info(name);
    return is_layer(name, info) && is_float(info.dtype) && (int8_ || size_of(info.dtype) > 2);
  }

  TensorInfos becomes(const std::string& name) const {
    const TensorInfo& info = from_.info(name);
    if (!is_rounded(name)) return {{name, info}};
    if (!int8_) return {{name, {DType::bf16, info.shape}}};
    return {{name, {DType::i8, info.shape}}, {scales_name(name), {DType::f32, {info.shape[0]}}}};
  }

  std::vector<Shard> lay_out() {
    std::vector<Shard> shards(1);
    std::uint64_t used = 0;
    for (const std::string& name : from_.names()) {
      std::uint64_t bytes = 0;
      const TensorInfos infos = becomes(name);
      for (const auto& [each, info] : infos) bytes += info.values() * size_of(info.dtype);
      if (used > 0 && used + bytes > shard_bytes) {
        shards.emplace_back();
        used = 0;
      }
      used += bytes;
      summary_.bytes_after += bytes;
      shards.back().names.push_back(name);
      shards.back().infos.insert(infos.begin(), infos.end());
    }
    summary_.bytes_before += from_.bytes();
    return shards;
  }

  void write_shard(const fs::path& file, const Shard& shard) {
    SafeTensorsWriter writer(file.string(), shard.infos, {{"format", "pt"}});
    long done = 0;
    for (const std::string& name : shard.names) {
      write_tensor(writer, name);
      from_.release(name);
      monitor_.step("converting", ++done, static_cast<long>(shard.names.size()));
    }
    writer.commit();
  }

  void write_tensor(SafeTensorsWriter& writer, const std::string& name) {
    const auto append = [&](const std::string& as, const at::Tensor& tensor) {
      const at::Tensor whole = tensor.contiguous();
      writer.append(as, {static_cast<const std::byte*>(whole.const_data_ptr()), whole.nbytes()});
    };
    const bool rounded = is_rounded(name);
    ++(rounded ? summary_.rounded : summary_.kept);
    if (!rounded) return append(name, from_.view(name));
    if (!int8_) return append(name, from_.view(name).to(at::kBFloat16));
    const QuantisedWeight weight = quantised(from_.view(name));
    append(name, weight.numbers);
    append(scales_name(name), weight.scales);
  }

  const WeightFiles& from_;
  bool int8_;
  ConversionSummary& summary_;
  Monitor& monitor_;
};

bool is_weights(const fs::path& file) {
  const std::string name = file.filename().string();
  return name.ends_with(".safetensors") || name.ends_with(".safetensors.index.json");
}

/// All of a folder but the weights that are written anew.
void copy_rest(const fs::path& from, const fs::path& to, bool weights_too) {
  fs::create_directories(to);
  for (const auto& entry : fs::directory_iterator(from))
    if (entry.is_regular_file() && (weights_too || !is_weights(entry.path())))
      fs::copy_file(entry.path(), to / entry.path().filename());
}

}  // namespace

void ConversionOptions::check() const {
  require(!model.empty() && !out.empty(), "convert: --model '{}' and --out '{}', wanted two folders", model, out);
  require(weights == "bf16" || weights == "int8", "convert: --weights '{}', wanted bf16 or int8", weights);
}

std::string ConversionSummary::brief() const {
  return fmt::format("{} tensors rounded, {} kept: {:.2f} GB became {:.2f} GB", rounded, kept,
                     static_cast<double>(bytes_before) / 1e9, static_cast<double>(bytes_after) / 1e9);
}

ConversionSummary convert_checkpoint(const ConversionOptions& options, Monitor& monitor) {
  options.check();
  const TorchScope scope(0);
  const fs::path from(options.model);
  if (!fs::is_directory(from)) fail(ErrorCode::file_not_found, "--model {}: no such folder", options.model);
  const std::string inside = fs::weakly_canonical(options.out).lexically_relative(fs::canonical(from)).string();
  if (!inside.empty() && !inside.starts_with(".."))
    fail(ErrorCode::output_failed, "--out {}: lies within --model {}; name a folder beside it", options.out,
         options.model);
  const bool whole = fs::exists(from / "transformer" / "config.json");
  if (!whole && !fs::exists(from / "config.json"))
    fail(ErrorCode::file_not_found, "--model {}: holds neither transformer/config.json nor config.json", options.model);

  NewFolder out(options.out);
  ConversionSummary summary;
  const auto convert = [&](const fs::path& part, const fs::path& to, bool text) {
    copy_rest(part, to, false);
    WeightFiles weights = WeightFiles::open(part.string());
    weights.rename(text ? umt5_name : transformer_diffusers_name);
    WeightsConversion(weights, options.weights == "int8", summary, monitor)
        .write(to, text ? "model" : "diffusion_pytorch_model");
  };
  try {
    if (!whole) convert(from, out.part(), false);
    if (whole) copy_rest(from, out.part(), true);
    for (const auto& entry : fs::directory_iterator(from)) {
      if (!whole || !entry.is_directory()) continue;
      const fs::path name = entry.path().filename();
      if (name == "transformer" || name == "text_encoder")
        convert(entry.path(), out.part() / name, name == "text_encoder");
      else
        copy_rest(entry.path(), out.part() / name, true);
    }
  } catch (const fs::filesystem_error& problem) {
    fail(ErrorCode::output_failed, "--out {}: {}", options.out, problem.what());
  }
  out.commit();
  return summary;
}

}  // namespace uwv
