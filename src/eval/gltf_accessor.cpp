// SPDX-License-Identifier: Apache-2.0
#include "gltf_accessor.h"

#include <cmath>
#include <cstdint>
#include <cstring>

#include "uwv/core/error.h"

namespace uwv {
namespace {

template <class T>
double number(const unsigned char* at, bool normalised) {
  T value;
  std::memcpy(&value, at, sizeof value);
  const double wide = static_cast<double>(value);
  if constexpr (std::is_integral_v<T>) {
    if (normalised) return std::max(wide / static_cast<double>(std::numeric_limits<T>::max()), -1.0);
  }
  return wide;
}

double number(int type, const unsigned char* at, bool normalised) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: return number<std::int8_t>(at, normalised);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return number<std::uint8_t>(at, normalised);
    case TINYGLTF_COMPONENT_TYPE_SHORT: return number<std::int16_t>(at, normalised);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return number<std::uint16_t>(at, normalised);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return number<std::uint32_t>(at, normalised);
    default: return number<float>(at, normalised);
  }
}

std::size_t size_of_type(int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT: return 4;
    default: return 0;
  }
}

}  // namespace

std::span<const unsigned char> GltfAccessors::bytes(int view) const {
  if (view < 0 || static_cast<std::size_t>(view) >= model_->bufferViews.size())
    fail(ErrorCode::file_damaged, "{}: buffer view {} is wanted, the file has {}", name_, view,
         model_->bufferViews.size());
  const tinygltf::BufferView& found = model_->bufferViews[static_cast<std::size_t>(view)];
  if (found.buffer < 0 || static_cast<std::size_t>(found.buffer) >= model_->buffers.size())
    fail(ErrorCode::file_damaged, "{}: buffer {} is wanted, the file has {}", name_, found.buffer,
         model_->buffers.size());
  const std::vector<unsigned char>& data = model_->buffers[static_cast<std::size_t>(found.buffer)].data;
  if (found.byteOffset > data.size() || found.byteLength > data.size() - found.byteOffset)
    fail(ErrorCode::file_damaged, "{}: buffer view {} wants bytes {} to {} of {}", name_, view, found.byteOffset,
         found.byteOffset + found.byteLength, data.size());
  return std::span(data).subspan(found.byteOffset, found.byteLength);
}

std::vector<double> GltfAccessors::read(int accessor, std::size_t components) const {
  if (accessor < 0 || static_cast<std::size_t>(accessor) >= model_->accessors.size())
    fail(ErrorCode::file_damaged, "{}: accessor {} is wanted, the file has {}", name_, accessor,
         model_->accessors.size());
  const tinygltf::Accessor& found = model_->accessors[static_cast<std::size_t>(accessor)];
  if (found.sparse.isSparse || found.bufferView < 0)
    fail(ErrorCode::value_invalid, "{}: accessor {} is sparse or empty, which is not supported", name_, accessor);
  const int has = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(found.type));
  if (has < 1 || static_cast<std::size_t>(has) != components)
    fail(ErrorCode::file_damaged, "{}: accessor {} has {} numbers a value, {} are wanted", name_, accessor, has,
         components);
  const std::size_t width = size_of_type(found.componentType);
  if (width == 0)
    fail(ErrorCode::file_damaged, "{}: accessor {} holds numbers of the unknown type {}", name_, accessor,
         found.componentType);

  const std::span<const unsigned char> data = bytes(found.bufferView);
  const std::size_t stated = model_->bufferViews[static_cast<std::size_t>(found.bufferView)].byteStride;
  const std::size_t value_bytes = width * components, stride = stated == 0 ? value_bytes : stated;
  // Written so that nothing overflows, whatever the file says.
  const bool fits = stride >= value_bytes && found.byteOffset <= data.size() &&
                    (found.count == 0 || (value_bytes <= data.size() - found.byteOffset &&
                                          found.count - 1 <= (data.size() - found.byteOffset - value_bytes) / stride));
  if (!fits)
    fail(ErrorCode::file_damaged, "{}: accessor {} wants {} values of {} bytes from byte {} on, its view has {} bytes",
         name_, accessor, found.count, value_bytes, found.byteOffset, data.size());

  std::vector<double> out;
  out.reserve(found.count * components);
  for (std::size_t i = 0; i < found.count; ++i)
    for (std::size_t c = 0; c < components; ++c) {
      const double value =
          number(found.componentType, data.data() + found.byteOffset + i * stride + c * width, found.normalized);
      if (!std::isfinite(value))
        fail(ErrorCode::file_damaged, "{}: accessor {} holds a number that is not finite", name_, accessor);
      out.push_back(value);
    }
  return out;
}

}  // namespace uwv
