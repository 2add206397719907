// Values that a PLY file stores with its vertices or faces, beyond their geometry.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "import/ply/ply_header.h"

namespace tessera::client {

/// One attribute, named as Mitsuba 3 names them: "vertex_" or "face_" and what the properties have in common.
struct PlyAttribute {
  std::string name;
  std::uint32_t channels = 1;  // 1 or 3
  bool per_face = false;
  std::vector<float> values;  // `channels` a vertex or triangle

  std::vector<int> properties;  // numbers of the PLY element's properties, one a channel
  /// Bits of integer properties, which stand for sRGB colours from 0 to all ones; 0: they are floats.
  int integer_bits = 0;

  /// The values of one face, once for each of its `triangles`.
  void append(const std::vector<double>& properties_of_face, std::size_t triangles);
  /// Integers become linear; InvalidArgument for a value that is not finite.
  absl::Status finish();
};

/// Groups the scalar properties of `element` that are not geometry. "r g b" and "red green blue" are "color";
/// neighbours "p_x p_y p_z", "p_0 p_1 p_2" or "p_1 p_2 p_3" are "p", "p_r p_g p_b" are "p_color", and a
/// single "p_0" (or p_x, p_r, p_1) is "p" with one channel. A fourth channel is left out. What fits nothing
/// is left out with a warning when its name has the form of an attribute's.
std::vector<PlyAttribute> plan_attributes(const PlyElement& element, bool per_face,
                                          std::vector<std::string>& warnings);

}  // namespace tessera::client
