// SPDX-License-Identifier: Apache-2.0
#include "model/sampling/scheduler_config.h"

#include <gmock/gmock.h>

#include "model/tensor_support.h"
#include "support/temp_folder.h"
#include "uwv/core/error.h"

namespace uwv::model {
namespace {

using ::testing::HasSubstr;
using uwv::testing::write_text;

std::string complaint(const std::string& text, ErrorCode code) {
  const test::TempFolder folder;
  write_text(folder.file("scheduler_config.json"), text);
  try {
    read_scheduler_config(folder.file("scheduler_config.json"));
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "accepted " << text;
  return "";
}

TEST(SchedulerConfig, ASettingThatWeDoNotHaveIsNamed) {
  const std::string unipc = R"({"_class_name":"UniPCMultistepScheduler","flow_shift":3,)";
  EXPECT_THAT(complaint(unipc + R"("solver_order":3})", ErrorCode::value_invalid), HasSubstr("/solver_order: found 3"));
  EXPECT_THAT(complaint(unipc + R"("prediction_type":"epsilon"})", ErrorCode::value_invalid),
              HasSubstr("wanted \"flow_prediction\""));
  EXPECT_THAT(complaint(unipc + R"("use_karras_sigmas":true})", ErrorCode::value_invalid), HasSubstr("karras"));
  EXPECT_THAT(complaint(R"({"_class_name":"DDIMScheduler"})", ErrorCode::value_invalid), HasSubstr("DDIMScheduler"));
}

TEST(SchedulerConfig, HostileFilesAreRefused) {
  for (const char* shift : {"0", "-1", "1e300", "\"5\"", "null", "[]"})
    EXPECT_THAT(complaint(fmt::format(R"({{"_class_name":"FlowMatchEulerDiscreteScheduler","shift":{}}})", shift),
                          ErrorCode::value_invalid),
                HasSubstr("/shift"));
  complaint("", ErrorCode::file_damaged);
  complaint("{", ErrorCode::file_damaged);
  complaint("[]", ErrorCode::value_invalid);
  complaint("{}", ErrorCode::value_invalid);
  complaint(R"({"_class_name":7})", ErrorCode::value_invalid);
  complaint(std::string(2U << 20U, ' '), ErrorCode::file_damaged);
  EXPECT_THROW(read_scheduler_config("/no/such/file.json"), Error);
}

}  // namespace
}  // namespace uwv::model
