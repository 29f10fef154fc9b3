// SPDX-License-Identifier: Apache-2.0
#include "model/layers/compute_device.h"

#include <ATen/ATen.h>
#include <gmock/gmock.h>

#include "model/complaint.h"
#include "model/diffusion/machine_speed.h"
#include "model/far_device.h"
#include "model/layers/torch_scope.h"
#include "uwv/model/compute_devices.h"

namespace uwv::model {
namespace {

using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;
using uwv::testing::far_device;

TEST(ComputeDevice, NamesMeanDevicesThatAreThere) {
  EXPECT_EQ(compute_device("cpu"), c10::Device(at::kCPU));
  EXPECT_EQ(compute_device(uwv::testing::far_device_name), far_device);
  EXPECT_EQ(compute_device("privateuseone:0"), far_device);
}

TEST(ComputeDevice, WhatIsAtHandIsListedTheCpuFirst) {
  const std::vector<ComputeDevice> devices = compute_devices();
  EXPECT_EQ(devices.front().name, "cpu");
  EXPECT_THAT(devices, Contains(Field(&ComputeDevice::name, "privateuseone:0")));
}

// With room for what else the machine does meanwhile.
TEST(FastNumbers, AreNotSlowWhereTheyAreCalledFastNorFastWhereTheyAreCalledSlow) {
  const TorchScope scope(1);
  const double f32 = linear_speed(LinearForm::f32, 1536), bf16 = linear_speed(LinearForm::bf16, 1536);
  if (fast_numbers().bf16)
    EXPECT_GT(bf16, 0.6 * f32);
  else
    EXPECT_LT(bf16, 1.7 * f32);
}

TEST(ComputeDevice, WhatIsNotThereIsRefusedWithWhatIs) {
  const auto complaint = [](const std::string& name, ErrorCode code) {
    return uwv::testing::complaint([&] { compute_device(name); }, code);
  };
  EXPECT_THAT(complaint("cuda:99", ErrorCode::backend_missing), HasSubstr("at hand: cpu"));
  EXPECT_THAT(complaint("privateuseone:7", ErrorCode::backend_missing), HasSubstr("privateuseone:0"));
  for (const char* name : {"", "gpu", "cuda:x", "cuda:-2", "meta", "cpu:"})
    EXPECT_THAT(complaint(name, ErrorCode::value_invalid), HasSubstr("wanted cpu, cuda")) << name;
}

/// The stand-in for a GPU must be as strict as one, or the tests on it say nothing.
TEST(FarDevice, RefusesTensorsOfTheCpuAndComputesAsTheCpu) {
  const at::Tensor x = at::randn({3, 4}), y = at::randn({3, 4});
  const at::Tensor far = x.to(far_device);
  EXPECT_EQ(far.device(), far_device);
  EXPECT_THROW(far + y, c10::Error);
  EXPECT_THROW(at::cat({far, y}), c10::Error);
  EXPECT_THROW(at::linear(far, y), c10::Error);
  EXPECT_TRUE(at::equal((far + y.to(far_device)).cpu(), x + y));
  at::Tensor changed = far.clone();
  changed.narrow(1, 1, 2).mul_(3);
  EXPECT_TRUE(at::equal(changed.select(1, 1).cpu(), x.select(1, 1) * 3));
  EXPECT_TRUE(at::equal(changed.select(1, 3).cpu(), x.select(1, 3)));
}

}  // namespace
}  // namespace uwv::model
