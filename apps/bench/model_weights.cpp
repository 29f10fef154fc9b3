// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "bench/model_commands.h"
#include "bench/model_shapes.h"
#include "bench/timing.h"
#include "model/transformer/transformer_config.h"
#include "model/transformer/transformer_shapes.h"
#include "uwv/core/error.h"
#include "uwv/core/thread_pool.h"
#include "uwv/io/safetensors_writer.h"

namespace uwv::bench {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t shard_bytes = 5'000'000'000, piece_values = 1 << 22;

/// Values are centre +- width, all equally likely.
struct Spread {
  float centre, width;
};

/// Spreads that keep numbers of order one through forty blocks: each layer's answer as wide as what it reads, norms
/// near one, biases and modulations small but there.
Spread spread_of(const std::string& name, const std::vector<std::int64_t>& shape) {
  if (name.ends_with(".gamma") || name.find("norm") != std::string::npos)
    return name.ends_with(".bias") ? Spread{0, 0.1F} : Spread{1, 0.1F};
  if (name == "uniview_ref_gates") return {0.25F, 0.1F};
  if (name.ends_with("scale_shift_table")) return {0, 0.5F};
  if (name == "shared.weight" || name.ends_with("relative_attention_bias.weight")) return {0, 1};
  if (shape.size() < 2) return {0, 0.05F};
  std::int64_t reads = 1;
  for (std::size_t i = 1; i < shape.size(); ++i) reads *= shape[i];
  return {0, std::sqrt(3.0F / static_cast<float>(reads))};
}

std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

/// Value `at` of a tensor depends on seed, name and `at` only: pieces can be made in any order.
float value_at(std::uint64_t key, std::uint64_t at, Spread spread) {
  const std::uint64_t four = mixed(key + at / 4 * 0x9e3779b97f4a7c15U);
  const auto sixteen = static_cast<std::uint16_t>(four >> (16 * (at % 4)));
  return spread.centre + spread.width * (static_cast<float>(sixteen) / 32767.5F - 1.0F);
}

std::uint16_t to_bf16(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return static_cast<std::uint16_t>((bits + 0x7fffU + ((bits >> 16) & 1U)) >> 16);
}

std::uint64_t key_of(std::uint64_t seed, const std::string& name) {
  std::uint64_t key = mixed(seed + 1);
  for (const char c : name) key = mixed(key + static_cast<unsigned char>(c));
  return key;
}

class Maker {
 public:
  explicit Maker(const ModelBenchOptions& options)
      : options_(options), type_(options.dtype == "f32" ? DType::f32 : DType::bf16), pool_(options.threads) {}

  /// Shards of `stem`-0000i-of-0000n.safetensors with their index, or one `stem`.safetensors.
  void write(const fs::path& folder, const std::string& stem, const Shapes& shapes) {
    std::vector<Shapes> shards(1);
    std::uint64_t used = 0, total = 0;
    for (const auto& [name, shape] : shapes) {
      const std::uint64_t bytes = values_of(shape) * size_of(type_);
      if (used + bytes > shard_bytes && used > 0) {
        shards.emplace_back();
        used = 0;
      }
      shards.back().emplace(name, shape);
      used += bytes;
      total += bytes;
    }
    if (shards.size() == 1) return write_file(folder / (stem + ".safetensors"), shapes);
    nlohmann::ordered_json index{{"metadata", {{"total_size", total}}},
                                 {"weight_map", nlohmann::ordered_json::object()}};
    for (std::size_t i = 0; i < shards.size(); ++i) {
      const std::string file = fmt::format("{}-{:05}-of-{:05}.safetensors", stem, i + 1, shards.size());
      write_file(folder / file, shards[i]);
      for (const auto& [name, shape] : shards[i]) index["weight_map"][name] = file;
    }
    write_text(folder / (stem + ".safetensors.index.json"), index.dump(2));
  }

  static void write_text(const fs::path& path, const std::string& text) {
    std::ofstream file(path);
    if (!(file << text).flush()) fail(ErrorCode::output_failed, "{}: cannot be written", path.string());
  }

 private:
  static std::uint64_t values_of(const std::vector<std::int64_t>& shape) {
    std::uint64_t values = 1;
    for (const std::int64_t size : shape) values *= static_cast<std::uint64_t>(size);
    return values;
  }

  void write_file(const fs::path& path, const Shapes& shapes) {
    TensorInfos infos;
    for (const auto& [name, shape] : shapes) infos[name] = {type_, {shape.begin(), shape.end()}};
    SafeTensorsWriter writer(path.string(), infos, {{"format", "pt"}});
    std::vector<std::byte> piece;
    for (const auto& [name, shape] : shapes) {
      const std::uint64_t values = values_of(shape), key = key_of(options_.seed, name);
      const Spread spread = spread_of(name, shape);
      for (std::uint64_t begin = 0; begin < values; begin += piece_values) {
        const std::uint64_t count = std::min(piece_values, values - begin);
        piece.resize(count * size_of(type_));
        fill(piece, begin, count, key, spread);
        writer.append(name, piece);
      }
    }
    writer.commit();
  }

  void fill(std::vector<std::byte>& piece, std::uint64_t begin, std::uint64_t count, std::uint64_t key, Spread spread) {
    pool_.for_ranges(0, static_cast<int>(count), 1 << 16, [&](int from, int to) {
      for (auto i = static_cast<std::uint64_t>(from); i < static_cast<std::uint64_t>(to); ++i) {
        const float value = value_at(key, begin + i, spread);
        if (type_ == DType::f32)
          reinterpret_cast<float*>(piece.data())[i] = value;
        else
          reinterpret_cast<std::uint16_t*>(piece.data())[i] = to_bf16(value);
      }
    });
  }

  const ModelBenchOptions& options_;
  DType type_;
  ThreadPool pool_;
};

/// The first layers of a transformer with what acts within them.
model::TransformerConfig shortened(model::TransformerConfig config, int layers) {
  config.layers = std::min(layers, config.layers);
  std::erase_if(config.vace_layers, [&](int layer) { return layer >= config.layers; });
  const auto blocks = static_cast<int>(config.vace_layers.size());
  std::erase_if(config.ref_at, [&](int block) { return block >= blocks; });
  if (config.ref_at.empty()) config.reference = model::ReferenceBranch::none;
  return config;
}

model::TransformerConfig transformer_config(const std::string& name) {
  if (name == "14b") return model::TransformerConfig::wan_14b();
  if (name == "1.3b") return model::TransformerConfig::wan_1_3b();
  model::TransformerConfig tiny;
  tiny.heads = 4;
  tiny.head_dim = 32;
  tiny.ffn_dim = 256;
  tiny.layers = 4;
  tiny.text_dim = 64;
  tiny.vace_layers = {0, 2};
  tiny.reference = model::ReferenceBranch::hint;
  tiny.ref_at = {0};
  return tiny;
}

std::string config_text(const model::TransformerConfig& config) {
  nlohmann::ordered_json json{{"_class_name", "WanVACETransformer3DModel"},
                              {"added_kv_proj_dim", nullptr},
                              {"attention_head_dim", config.head_dim},
                              {"cross_attn_norm", config.cross_attn_norm},
                              {"eps", config.eps},
                              {"ffn_dim", config.ffn_dim},
                              {"freq_dim", config.freq_dim},
                              {"image_dim", nullptr},
                              {"in_channels", config.in_channels},
                              {"num_attention_heads", config.heads},
                              {"num_layers", config.layers},
                              {"out_channels", config.out_channels},
                              {"patch_size", config.patch},
                              {"pos_embed_seq_len", nullptr},
                              {"qk_norm", "rms_norm_across_heads"},
                              {"rope_max_seq_len", 1024},
                              {"text_dim", config.text_dim},
                              {"vace_in_channels", config.vace_in_channels},
                              {"vace_layers", config.vace_layers}};
  if (config.reference == model::ReferenceBranch::hint) {
    json["uniview_ref_in_channels"] = config.ref_in_channels;
    json["uniview_ref_inject_vace_block_indices"] = config.ref_at;
    json["uniview_ref_num_inject"] = config.ref_at.size();
  }
  return json.dump(2);
}

/// What diffusers reads first: which parts the folder has, and the steps' scheduler.
void write_model_index(const fs::path& folder) {
  nlohmann::ordered_json index{{"_class_name", "WanVACEPipeline"}};
  const std::vector<std::tuple<const char*, const char*, const char*>> parts{
      {"transformer", "diffusers", "WanVACETransformer3DModel"},
      {"vae", "diffusers", "AutoencoderKLWan"},
      {"text_encoder", "transformers", "UMT5EncoderModel"},
      {"scheduler", "diffusers", "FlowMatchEulerDiscreteScheduler"}};
  fs::create_directories(folder / "scheduler");
  Maker::write_text(folder / "scheduler" / "scheduler_config.json",
                    R"({"_class_name": "FlowMatchEulerDiscreteScheduler", "num_train_timesteps": 1000, "shift": 5.0})");
  for (const auto& [name, library, kind] : parts)
    if (fs::exists(folder / name)) index[name] = {library, kind};
  Maker::write_text(folder / "model_index.json", index.dump(2));
}

}  // namespace

std::vector<Table> make_weights(const ModelBenchOptions& options) {
  struct Part {
    std::string folder, stem, config;
    Shapes shapes;
  };
  Part part;
  if (options.config == "vae") {
    part = {"vae", "diffusion_pytorch_model", vae_config(), vae_shapes()};
  } else if (options.config == "text") {
    part = {"text_encoder", "model", text_encoder_config(), text_encoder_shapes()};
  } else {
    model::TransformerConfig config = transformer_config(options.config);
    if (options.layers > 0) config = shortened(std::move(config), options.layers);
    part = {"transformer", "diffusion_pytorch_model", config_text(config), model::transformer_shapes(config)};
  }
  const fs::path folder = fs::path(options.out) / part.folder;
  std::error_code problem;
  fs::create_directories(folder, problem);
  if (problem) fail(ErrorCode::output_failed, "{}: cannot be made: {}", folder.string(), problem.message());
  const Stopwatch watch;
  Maker::write_text(folder / "config.json", part.config);
  Maker(options).write(folder, part.stem, part.shapes);
  write_model_index(options.out);
  std::uint64_t bytes = 0;
  for (const auto& entry : fs::directory_iterator(folder)) bytes += entry.file_size();
  Table table("weights", {"folder", "tensors", "gigabytes", "seconds"});
  table.add({folder.string(), part.shapes.size(), static_cast<double>(bytes) / 1e9, watch.seconds()});
  return {table};
}

}  // namespace uwv::bench
