// Uses of accessors and buffer views: each for one thing alone.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "import/gltf/context.h"

namespace tessera::client::gltf {

enum class Usage { kVertices, kIndices, kInverseBindMatrices, kTimes, kKeys };

/// Demands on the values of an accessor, beyond that they are finite.
struct Demands {
  bool unit_vectors = false;       // three components of length 1
  bool tangents = false;           // the same, and a sign
  bool rotations = false;          // four components of length 1
  bool placings = false;           // matrices that move, turn and scale
  std::size_t spline_part = 0;     // 3: only the second of three elements is a rotation
  std::uint64_t vertices = ~0ull;  // indices are below
};

class AccessorUses {
 public:
  explicit AccessorUses(Context& context) : context_(context) {}

  /// Says that `place` uses an accessor so; reports what does not go together with other uses.
  void add(std::size_t accessor, Usage usage, const std::string& place);
  /// The same of a view that is an image, or belongs to a sparse accessor.
  void add_other(std::size_t view, const std::string& place);
  Demands& demands(std::size_t accessor) { return demands_[accessor]; }
  const std::map<std::size_t, Demands>& all_demands() const { return demands_; }

 private:
  enum class ViewUsage { kVertices, kIndices, kOther };
  void add_view(std::size_t view, ViewUsage usage, const std::string& place);

  Context& context_;
  std::map<std::size_t, Usage> usages_;
  std::map<std::size_t, ViewUsage> view_usages_;
  std::map<std::size_t, std::size_t> tight_views_;  // without stride, and the accessor of vertices in each
  std::map<std::size_t, Demands> demands_;
};

}  // namespace tessera::client::gltf
