// SPDX-License-Identifier: Apache-2.0
#include "model/script_module.h"

#include <ATen/Parallel.h>
#include <torch/script.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "io/disk_file.h"
#include "io/printable.h"
#include "io/zip_directory.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

/// An output larger than this (8 GiB) is an accident: a tensor expanded without end, or a size the manifest got wrong.
constexpr std::int64_t most_numbers = std::int64_t{1} << 31;

constexpr const char* wanted =
    "a TorchScript archive is wanted: torch.jit.trace(network, example).save(path) makes one";

/// torch's message without its back trace, on one line.
std::string first_words(const std::exception& error) {
  std::string_view text = error.what();
  if (const auto* torch_error = dynamic_cast<const c10::Error*>(&error)) text = torch_error->what_without_backtrace();
  // The interpreter puts the reason last, after a listing of the network's source.
  if (const auto reason = text.rfind("RuntimeError: "); reason != std::string_view::npos) text.remove_prefix(reason);
  while (!text.empty() && (text.front() == '\n' || text.front() == ' ')) text.remove_prefix(1);
  return io::printable(text.substr(0, text.find('\n')));
}

bool ends_with_member(const std::vector<io::ZipMember>& members, std::string_view end) {
  return std::any_of(members.begin(), members.end(), [end](const auto& m) { return m.name.ends_with(end); });
}

/// Refuses what people give by mistake, before torch gets to see it: its own words explain little.
void check_file_type(const io::InputFile& file) {
  std::array<unsigned char, 16> head{};
  const std::size_t known = static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), head.size()));
  file.read_at(0, std::as_writable_bytes(std::span(head).first(known)));
  if (known == 0) fail(ErrorCode::file_damaged, "{}: is empty; {}", file.path(), wanted);
  if (head[0] == 0x80)
    fail(ErrorCode::format_unknown, "{}: is a Python pickle (weights without a network?); {}", file.path(), wanted);
  if (head[8] == '{' && known > 8)
    fail(ErrorCode::format_unknown, "{}: looks like safetensors, weights without a network; {}", file.path(), wanted);
  if (head[0] != 'P' || head[1] != 'K')
    fail(ErrorCode::format_unknown, "{}: is not a zip archive, as TorchScript files are; {}", file.path(), wanted);
  const std::vector<io::ZipMember> members = io::read_zip_directory(file);
  if (ends_with_member(members, "/constants.pkl")) return;
  if (ends_with_member(members, "/data.pkl"))
    fail(ErrorCode::format_unknown, "{}: is what torch.save writes (a state dict?), weights without a network; {}",
         file.path(), wanted);
  if (ends_with_member(members, ".json"))
    fail(ErrorCode::format_unknown, "{}: looks like an archive of torch.export; {}", file.path(), wanted);
  fail(ErrorCode::format_unknown, "{}: is a zip archive without constants.pkl; {}", file.path(), wanted);
}

void check_signature(const torch::jit::Module& module, int inputs, const std::string& path) {
  const auto method = module.find_method("forward");
  if (!method) fail(ErrorCode::value_invalid, "{}: has no method 'forward'; {}", path, wanted);
  const auto& arguments = method->function().getSchema().arguments();
  const auto required = std::count_if(arguments.begin(), arguments.end(),
                                      [](const c10::Argument& argument) { return !argument.default_value(); }) -
                        1;
  const auto taken = static_cast<long>(arguments.size()) - 1;
  if (required > inputs || taken < inputs)
    fail(ErrorCode::value_invalid, "{}: forward takes {} inputs, {} wanted; export a wrapper that fixes the others",
         path, taken < inputs ? taken : required,
         inputs == 1 ? "one picture tensor is" : "pictures and prompt points are");
}

c10::ScalarType scalar_type(TensorType type) {
  if (type == TensorType::bfloat16) return torch::kBFloat16;
  return type == TensorType::float16 ? torch::kHalf : torch::kFloat;
}

FloatTensor copied(const torch::Tensor& tensor) {
  const torch::Tensor floats = tensor.to(torch::kCPU, torch::kFloat).contiguous();
  const float* first = floats.const_data_ptr<float>();
  return {floats.sizes().vec(), {first, first + floats.numel()}};
}

void append(const c10::IValue& value, const std::string& path, ModuleOutputs& outputs) {
  if (value.isNone()) {
    outputs.tensors.push_back({{0}, {}});
  } else if (value.isTensor() && value.toTensor().defined() && !value.toTensor().is_complex()) {
    if (value.toTensor().numel() > most_numbers)
      fail(ErrorCode::value_invalid, "{}: output number {} has {} numbers; at most {} are taken", path,
           outputs.tensors.size(), value.toTensor().numel(), most_numbers);
    outputs.tensors.push_back(copied(value.toTensor()));
  } else {
    fail(ErrorCode::value_invalid, "{}: output number {} is a {}; tensors of real numbers are wanted", path,
         outputs.tensors.size(), value.tagKind());
  }
}

ModuleOutputs unpacked(const c10::IValue& value, const std::string& path) {
  ModuleOutputs outputs;
  if (value.isTuple()) {
    for (const c10::IValue& element : value.toTupleRef().elements()) append(element, path, outputs);
  } else if (value.isList()) {
    for (const c10::IValue& element : value.toListRef()) append(element, path, outputs);
  } else if (value.isGenericDict()) {
    for (const auto& entry : value.toGenericDict()) {
      if (!entry.key().isString())
        fail(ErrorCode::value_invalid, "{}: returns a dictionary whose keys are no strings", path);
      outputs.names.push_back(entry.key().toStringRef());
      append(entry.value(), path, outputs);
    }
  } else {
    append(value, path, outputs);
  }
  return outputs;
}

/// torch's number of threads for as long as this lives.
class TorchThreads {
 public:
  explicit TorchThreads(int threads) : before_(at::get_num_threads()) {
    if (threads != before_) at::set_num_threads(threads);
  }
  ~TorchThreads() {
    if (at::get_num_threads() != before_) at::set_num_threads(before_);
  }
  TorchThreads(const TorchThreads&) = delete;
  TorchThreads& operator=(const TorchThreads&) = delete;

 private:
  int before_;
};

}  // namespace

struct ScriptModule::State {
  torch::jit::Module module;
};

ScriptModule::ScriptModule(const std::string& path, int inputs) : path_(path), state_(std::make_unique<State>()) {
  check_file_type(io::InputFile(path));
  try {
    state_->module = torch::jit::load(path, torch::kCPU);
    state_->module.eval();
  } catch (const std::exception& error) {
    fail(ErrorCode::file_damaged,
         "{}: torch cannot load it ({}); export it anew with this version of torch or an older one", path,
         first_words(error));
  }
  check_signature(state_->module, inputs, path);
}

ScriptModule::~ScriptModule() = default;
ScriptModule::ScriptModule(ScriptModule&&) noexcept = default;

ModuleOutputs ScriptModule::forward(std::span<const FloatTensor> inputs, TensorType type, int threads) {
  const TorchThreads guard(threads);
  const c10::InferenceMode no_gradients;
  // Without this the first two calls run other code than the later ones: slower, and with other rounding.
  const torch::jit::GraphOptimizerEnabledGuard same_code_each_call(false);
  const auto no_memory = [&] {
    fail(ErrorCode::out_of_memory,
         "{}: memory ran out for an input of {}; fewer pixels ('input' in the manifest) or frames need less", path_,
         shape_text(inputs.front().shape));
  };
  try {
    std::vector<c10::IValue> arguments;
    for (const FloatTensor& input : inputs) {
      // The tensor only borrows the memory; networks that write into their input get a copy of it.
      const torch::Tensor tensor =
          torch::from_blob(const_cast<float*>(input.values.data()), input.shape, torch::kFloat);
      arguments.emplace_back(tensor.to(scalar_type(type), false, true));
    }
    return unpacked(state_->module.forward(arguments), path_);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    no_memory();
  } catch (const std::exception& error) {
    // torch's allocator reports a lack of memory as any other error.
    if (std::string_view(error.what()).find("DefaultCPUAllocator") != std::string_view::npos) no_memory();
    fail(ErrorCode::value_invalid,
         "{}: the network failed on an input of {} ({}); compare 'input' in the manifest with how it was exported",
         path_, shape_text(inputs.front().shape), first_words(error));
  }
  return {};
}

}  // namespace uwv::model
