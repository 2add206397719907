// Which numbers a Scene message may hold: client and worker hold each other to the same.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::wire {

/// Largest magnitude of a number of a scene, whatever its unit. The renderer calculates in 32-bit floats:
/// squares of such lengths, and their sums, are still finite.
inline constexpr double kLargestSceneNumber = 1e18;

/// Whether a scene may hold `x`: finite, and not beyond kLargestSceneNumber.
inline bool is_scene_number(double x) { return x >= -kLargestSceneNumber && x <= kLargestSceneNumber; }

/// Such numbers, in messages of those who read them.
inline constexpr char kSceneNumberRange[] = "a number from -1e18 to 1e18";

/// Smallest and largest index of refraction that single precision can work with.
inline constexpr float kLeastIndex = 1e-4f, kLargestIndex = 1e4f;

/// Returns what is wrong with an index of refraction that the material has; empty: nothing.
std::string index_fault(const v1::Material& material);
/// InvalidArgument for an index beyond these bounds.
absl::Status check_index(float eta);

/// A number of a scene that is_scene_number() refuses.
struct BadNumber {
  /// From the scene down to the number's own field, with the index within repeated fields (-1 for others).
  std::vector<std::pair<const google::protobuf::FieldDescriptor*, int>> path;
  std::string element;  // the name of the element of the scene that holds it, where it has one
  double value = 0;

  /// "shapes[3].sphere.radius (lamp): 1e+38 is beyond 1e+18, the largest magnitude of a number of a scene"
  std::string to_string() const;
};

/// Returns such numbers of `scene` in the order of fields, at most so many; looks into every floating-point
/// field of every message.
std::vector<BadNumber> find_bad_numbers(const v1::Scene& scene, std::size_t most);

/// InvalidArgument with the text of the first of them.
absl::Status check_scene_numbers(const v1::Scene& scene);

}  // namespace tessera::wire
