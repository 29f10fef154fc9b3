// SPDX-License-Identifier: Apache-2.0
#include "model/layers/compute_device.h"

#include <ATen/ATen.h>
#include <c10/core/CachingDeviceAllocator.h>
#include <c10/core/impl/DeviceGuardImplInterface.h>

#include <array>

#include "io/printable.h"
#include "uwv/core/error.h"
#include "uwv/model/compute_devices.h"

namespace uwv::model {
namespace {

/// Kinds of device that hold tensors and multiply them; libtorch has others for its own ends.
constexpr std::array kinds{at::kCUDA, at::kHIP, at::kXPU, at::kMPS, at::kPrivateUse1};

c10::DeviceIndex count(c10::DeviceType kind) {
  return c10::impl::hasDeviceGuardImpl(kind) ? c10::impl::getDeviceGuardImpl(kind)->deviceCount() : 0;
}

std::string at_hand() {
  std::string names;
  for (const ComputeDevice& device : compute_devices()) names += (names.empty() ? "" : ", ") + device.name;
  return names;
}

c10::Device named(const std::string& name) {
  try {
    const c10::Device device(name);
    for (const c10::DeviceType kind : kinds)
      if (device.type() == kind) return {kind, std::max<c10::DeviceIndex>(device.index(), 0)};
    if (device.is_cpu()) return at::kCPU;
  } catch (const c10::Error&) {
    // told below, in words of ours
  }
  fail(ErrorCode::value_invalid,
       "--device: found '{}', wanted cpu, cuda, cuda:N or another kind libtorch knows; "
       "at hand: {}",
       io::printable(name), at_hand());
}

}  // namespace

c10::Device compute_device(const std::string& name) {
  const c10::Device device = named(name);
  if (device.is_cpu()) return device;
  if (device.index() >= count(device.type()))
    fail(ErrorCode::backend_missing, "--device {}: this libtorch finds no such device; at hand: {}", name, at_hand());
  try {
    at::zeros({1}, at::TensorOptions(device));
  } catch (const c10::Error& error) {
    const std::string reason = error.what_without_backtrace();
    fail(ErrorCode::backend_missing, "--device {}: it does not work ({}); at hand: {}", name,
         io::printable(reason.substr(0, reason.find('\n'))), at_hand());
  }
  return device;
}

std::optional<std::uint64_t> free_bytes(c10::Device device) {
  if (device.is_cpu()) return std::nullopt;
  try {
    return c10::getDeviceAllocator(device.type())->getMemoryInfo(device.index()).first;
  } catch (const c10::Error&) {
    return std::nullopt;
  }
}

}  // namespace uwv::model

namespace uwv {

std::vector<ComputeDevice> compute_devices() {
  std::vector<ComputeDevice> devices{{"cpu", std::nullopt}};
  for (const c10::DeviceType kind : model::kinds)
    for (c10::DeviceIndex index = 0; index < model::count(kind); ++index) {
      const c10::Device device(kind, index);
      devices.push_back({device.str(), model::free_bytes(device)});
    }
  return devices;
}

}  // namespace uwv
