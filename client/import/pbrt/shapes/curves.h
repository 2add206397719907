// Shape "curve" -> Curves messages, many strands in one.
#pragma once

#include <cstdint>
#include <vector>

#include "import/pbrt/matter/textures.h"

namespace tessera::client::pbrt {

/// Cubic Bezier segments on their way into one Shape.
struct CurveBatch {
  /// Segments of one shape at most: a blob of them stays below 300 MB.
  static constexpr std::size_t kMaxSegments = std::size_t{1} << 22;

  v1::Curves::Kind kind = v1::Curves::FLAT;
  std::vector<float> points;          // x y z radius
  std::vector<std::uint32_t> starts;  // first control point of each segment
  std::vector<float> normals;         // RIBBON: x y z a control point
};

/// "type" of a curve; reports what it does not know.
v1::Curves::Kind read_curve_kind(ValueReader& values);

/// Appends the segments of one Shape "curve" of the batch's kind. False after an error.
bool append_curve(ValueReader& values, CurveBatch& batch);

/// Adds all segments of `more`, of the same kind, to `batch`.
void append(const CurveBatch& more, CurveBatch& batch);

void write_curves(const CurveBatch& batch, BlobCollector& blobs, v1::Curves& curves);

}  // namespace tessera::client::pbrt
