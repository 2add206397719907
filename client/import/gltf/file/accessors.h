// Numbers out of accessors, of whatever type they are stored as.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/functional/function_ref.h"
#include "import/gltf/context.h"
#include "import/gltf/file/buffers.h"

namespace tessera::client::gltf {

/// Component types, by OpenGL's numbers.
enum class Component : int {
  kByte = 5120,
  kUnsignedByte = 5121,
  kShort = 5122,
  kUnsignedShort = 5123,
  kUnsignedInt = 5125,
  kFloat = 5126
};

struct Accessor {
  std::size_t count = 0;
  int components = 0;  // components of an element, 1 to 16
  Component component = Component::kFloat;
  bool normalized = false;
  std::string format;  // "VEC3 f32", "VEC4 u8n": normalized integers end with n

  bool is_integer() const { return component != Component::kFloat; }
  std::size_t component_size() const;  // bytes
};

class AccessorTable {
 public:
  /// Checks all accessors against what they view; what is wrong is reported.
  AccessorTable(Context& context, BufferTable& buffers);

  const Accessor& operator[](std::size_t index) const { return accessors_[index]; }

  /// All components of all elements; normalized integers become [-1, 1] or [0, 1]. Nothing where something is
  /// wrong, which has been reported: also a number that is not finite.
  std::optional<std::vector<float>> read(std::size_t index);
  /// Calls put(element, component, number) for all that the accessor has, as it is stored: elements without
  /// data are not met, replaced ones twice. False where something is wrong, which has been reported.
  bool visit(std::size_t index, absl::FunctionRef<void(std::size_t, int, double)> put);
  /// Integers as they are. Only of accessors that have them.
  std::optional<std::vector<std::uint32_t>> read_integers(std::size_t index);

 private:
  void check(std::size_t index);
  void check_sparse(const Json& sparse, const Accessor& accessor, const std::string& place);
  bool check_span(std::size_t view, std::size_t offset, std::size_t count, std::size_t element,
                  std::size_t component, const std::string& place);

  Context& context_;
  BufferTable& buffers_;
  std::vector<Accessor> accessors_;
};

}  // namespace tessera::client::gltf
