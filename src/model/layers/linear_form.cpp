// SPDX-License-Identifier: Apache-2.0
#include "model/layers/linear_form.h"

#include <fmt/format.h>

#include <array>
#include <stdexcept>

#include "uwv/model/compute_devices.h"

namespace uwv::model {
namespace {

struct FormName {
  LinearForm form;
  const char* name;
};
constexpr std::array form_names{FormName{LinearForm::f32, "f32"}, FormName{LinearForm::bf16_stored, "bf16_stored"},
                                FormName{LinearForm::bf16, "bf16"}, FormName{LinearForm::int8_stored, "int8_stored"},
                                FormName{LinearForm::int8, "int8"}};

}  // namespace

int token_bytes(LinearForm form) {
  return form == LinearForm::bf16 || (form == LinearForm::int8 && fast_numbers().bf16) ? 2 : 4;
}

std::string to_string(LinearForm form) {
  for (const FormName& each : form_names)
    if (each.form == form) return each.name;
  return "unknown";
}

LinearForm linear_form(const std::string& name) {
  std::string known;
  for (const FormName& each : form_names) {
    if (name == each.name) return each.form;
    known += (known.empty() ? "" : ", ") + std::string(each.name);
  }
  throw std::invalid_argument(fmt::format("a linear form named '{}', wanted one of {}", name, known));
}

}  // namespace uwv::model
