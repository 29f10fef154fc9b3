// SPDX-License-Identifier: Apache-2.0
// Links the component uwv::model and asks for a network that is not there.
#include <uwv/core/error.h>
#include <uwv/model/depth_network.h>

#include <cstdio>

int main() {
  try {
    uwv::open_depth_network("no-such-folder");
  } catch (const uwv::Error& error) {
    std::puts(error.what());
  }
}
