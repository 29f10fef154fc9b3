// SPDX-License-Identifier: Apache-2.0
#include "model/script_nets.h"

#include <torch/script.h>

#include <fstream>

namespace uwv::test {

void save_script(const std::string& path, const std::string& source) {
  torch::jit::Module module("net");
  module.define(source);
  module.save(path);
}

void save_tensor_only(const std::string& path) {
  const std::vector<char> bytes = torch::jit::pickle_save(torch::ones({2, 2}));
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace uwv::test
