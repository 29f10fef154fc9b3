// SPDX-License-Identifier: Apache-2.0
#include "model/far_device.h"

#include <ATen/ATen.h>
#include <ATen/EmptyTensor.h>
#include <ATen/native/CPUFallback.h>
#include <ATen/ops/_reshape_alias_native.h>
#include <ATen/ops/as_strided_native.h>
#include <ATen/ops/view_native.h>
#include <c10/core/Allocator.h>
#include <c10/core/impl/DeviceGuardImplInterface.h>
#include <torch/library.h>

#include <atomic>
#include <cstdlib>
#include <cstring>

namespace uwv::testing {
namespace {

/// No address of a program has this bit: to read there ends it.
constexpr std::uintptr_t far_bit = std::uintptr_t{1} << 62U;
constexpr c10::DispatchKeySet keys(c10::DispatchKey::PrivateUse1);

void* away(void* pointer) { return reinterpret_cast<void*>(reinterpret_cast<std::uintptr_t>(pointer) | far_bit); }
void* back(const void* pointer) {
  return reinterpret_cast<void*>(reinterpret_cast<std::uintptr_t>(pointer) & ~far_bit);
}

class FarMemory final : public c10::Allocator {
 public:
  c10::DataPtr allocate(std::size_t bytes) override {
    void* memory = std::malloc(std::max<std::size_t>(bytes, 1));
    return {away(memory), memory, &std::free, far_device};
  }
  void copy_data(void* to, const void* from, std::size_t bytes) const override {
    std::memcpy(back(to), back(from), bytes);
  }
};

c10::Allocator* far_memory() {
  static FarMemory memory;
  return &memory;
}

struct FarGuard final : c10::impl::NoOpDeviceGuardImpl<c10::DeviceType::PrivateUse1> {
  c10::Device exchangeDevice(c10::Device) const override { return far_device; }
  c10::Device getDevice() const override { return far_device; }
};

std::atomic<std::int64_t>& count() {
  static std::atomic<std::int64_t> operators{0};
  return operators;
}

/// The same memory as a tensor of the CPU.
at::Tensor seen_near(const at::Tensor& tensor) {
  if (tensor.is_cpu()) return tensor;
  return at::from_blob(back(tensor.data_ptr()), tensor.sizes(), tensor.strides(),
                       at::TensorOptions(tensor.scalar_type()));
}

at::Tensor empty(at::IntArrayRef size, std::optional<at::ScalarType> type, std::optional<at::Layout>,
                 std::optional<at::Device>, std::optional<bool>, std::optional<at::MemoryFormat> format) {
  return at::detail::empty_generic(size, far_memory(), keys, type.value_or(at::kFloat), format);
}

at::Tensor empty_strided(at::IntArrayRef size, at::IntArrayRef stride, std::optional<at::ScalarType> type,
                         std::optional<at::Layout>, std::optional<at::Device>, std::optional<bool>) {
  return at::detail::empty_strided_generic(size, stride, far_memory(), keys, type.value_or(at::kFloat));
}

at::Tensor copy_from(const at::Tensor& from, const at::Tensor& to, bool) {
  seen_near(to).copy_(seen_near(from));
  return to;
}

/// Operators hand in answers without numbers to be given their size.
at::Tensor copy_and_resize(const at::Tensor& from, const at::Tensor& to) {
  if (from.sizes() != to.sizes()) {
    TORCH_CHECK(to.numel() == 0, "an answer of ", from.sizes(), " does not fit a place of ", to.sizes());
    const at::Tensor room = at::empty(from.sizes(), to.options());
    to.unsafeGetTensorImpl()->set_storage_keep_dtype(room.storage());
    to.unsafeGetTensorImpl()->set_sizes_contiguous(from.sizes());
  }
  return copy_from(from, to, false);
}

at::Tensor convolution(const at::Tensor& x, const at::Tensor& weight, const std::optional<at::Tensor>& bias,
                       at::IntArrayRef stride, at::IntArrayRef padding, at::IntArrayRef dilation, bool transposed,
                       at::IntArrayRef output_padding, std::int64_t groups) {
  TORCH_CHECK(x.device() == weight.device() && (!bias || !bias->defined() || bias->device() == x.device()),
              "a convolution of tensors on several devices");
  const std::optional<at::Tensor> near_bias = bias && bias->defined() ? std::optional(seen_near(*bias)) : std::nullopt;
  return at::convolution(seen_near(x), seen_near(weight), near_bias, stride, padding, dilation, transposed,
                         output_padding, groups)
      .to(far_device);
}

/// Numbers without axes may come from the CPU, as to a GPU.
void check_device(const at::Tensor& tensor, const c10::OperatorHandle& op) {
  TORCH_CHECK(!tensor.defined() || !tensor.is_cpu() || tensor.dim() == 0, op.schema().name(),
              ": a tensor of the CPU meets one of the far device");
}

void check_devices(const c10::IValue& value, const c10::OperatorHandle& op) {
  if (value.isTensor()) check_device(value.toTensor(), op);
  if (value.isList())
    for (const c10::IValue& element : value.toListRef()) check_devices(element, op);
}

void on_cpu(const c10::OperatorHandle& op, torch::jit::Stack* stack) {
  ++count();
  for (const c10::IValue& argument : torch::jit::last(*stack, op.schema().arguments().size()))
    check_devices(argument, op);
  at::native::cpu_fallback(op, stack, /*error_on_views=*/true);
}

C10_REGISTER_GUARD_IMPL(PrivateUse1, FarGuard)

TORCH_LIBRARY_IMPL(_, PrivateUse1, library) { library.fallback(torch::CppFunction::makeFromBoxedFunction<&on_cpu>()); }

TORCH_LIBRARY_IMPL(aten, PrivateUse1, library) {
  library.impl("empty.memory_format", &empty);
  library.impl("empty_strided", &empty_strided);
  library.impl("_copy_from", &copy_from);
  library.impl("_copy_from_and_resize", &copy_and_resize);
  library.impl("convolution_overrideable", &convolution);
  library.impl("view", &at::native::view);
  library.impl("as_strided", &at::native::as_strided_tensorimpl);
  library.impl("_reshape_alias", &at::native::_reshape_alias);
}

}  // namespace

std::int64_t far_operators() { return count(); }

}  // namespace uwv::testing
