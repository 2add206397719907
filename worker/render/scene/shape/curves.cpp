// Curves.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "absl/strings/str_cat.h"
#include "render/scene/shape/geometry.h"
#include "render/scene/shape/shape_kinds.h"
#include "render/scene/values/located.h"

namespace tessera::render {

namespace {

/// The kernels gather floats with 32-bit indices.
constexpr std::size_t kMostPoints = std::numeric_limits<std::int32_t>::max() / 8;

constexpr const char* kUnusablePoint =
    "a control point is not finite once it is placed in the world, or its radius is below 0";

/// A blob as an array of T; `group` values make one entry.
template <typename T>
absl::StatusOr<std::vector<T>> array_of(const BlobSource& blobs, const v1::BlobRef& ref, const char* what,
                                        std::size_t group) {
  const auto blob = blobs(ref.digest());
  if (!blob.ok()) return located(blob.status(), absl::StrCat(what, " of curves"));
  if (blob->bytes.size() % (group * sizeof(T)) != 0) {
    return absl::InvalidArgumentError(absl::StrCat("the ", what, " of its curves are not whole"));
  }
  std::vector<T> values(blob->bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), blob->bytes.data(), blob->bytes.size());
  return values;
}

/// How many straight pieces keep every segment within a twentieth of its width [as pbrt-v4 cuts its curves
/// up], as far as Embree can at its full speed.
std::int32_t pieces_of(const CurvesRecord& curves) {
  constexpr double kTolerance = 0.05;
  double most = 1;
  const auto keys = static_cast<std::size_t>(curves.key_segments) + 1, count = curves.points.size() / keys;
  for (std::size_t i = 0; i < keys * curves.starts.size(); ++i) {
    const std::size_t key = i / curves.starts.size();
    const CurvePoint* p = &curves.points[key * count + curves.starts[i % curves.starts.size()]];
    double bend = 0, radius = 0;
    for (int k = 0; k < 4; ++k) radius = std::max(radius, double{p[k].radius});
    for (int k = 0; k < 2; ++k) {
      double squared = 0;
      for (int a = 0; a < 3; ++a) {
        const double second = double{p[k].position[a]} - 2 * p[k + 1].position[a] + p[k + 2].position[a];
        squared += second * second;
      }
      bend = std::max(bend, std::sqrt(squared));
    }
    // |B''| <= 6 bend for Bezier curves, bend for B-splines; a chord of 1 / n leaves the curve by |B''| / (8
    // n^2).
    const double second = (curves.bspline ? 1 : 6) * bend;
    if (radius > 0) most = std::max(most, std::sqrt(second / (8 * kTolerance * 2 * radius)));
  }
  return static_cast<std::int32_t>(std::clamp(std::ceil(most), 4.0, 16.0));
}

/// Appends control points. False when one is not finite, or its radius below 0.
bool place_points(const std::vector<float>& values, const Transform& placed_from_object,
                  CurvesRecord& curves) {
  const double scale = std::cbrt(std::abs(placed_from_object.determinant()));
  bool sound = true;
  const std::size_t first = curves.points.size();
  curves.points.resize(first + values.size() / 4);
  for (std::size_t i = 0; i < values.size() / 4; ++i) {
    const float* v = &values[4 * i];
    const Imath::V3d p = placed_from_object.apply({v[0], v[1], v[2]});
    CurvePoint& point = curves.points[first + i];
    point = {{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)},
             static_cast<float>(v[3] * scale)};
    for (const float x : point.position) sound = sound && std::isfinite(x);
    sound = sound && point.radius >= 0 && std::isfinite(point.radius);
  }
  return sound;
}

/// Appends the control points of later keys.
absl::Status append_keys(const v1::Curves& message, const Transform& placed_from_object,
                         const BlobSource& blobs, CurvesRecord& curves) {
  const std::size_t count = curves.points.size();
  curves.key_segments = message.later_points_size();
  if (curves.key_segments > kMostKeySegments) {
    return absl::InvalidArgumentError(
        absl::StrCat("they have ", curves.key_segments, " later keys; at most ", kMostKeySegments));
  }
  if (count * (static_cast<std::size_t>(curves.key_segments) + 1) > kMostPoints)
    return absl::InvalidArgumentError(
        absl::StrCat("curves have at most ", kMostPoints, " control points in all of their keys"));
  for (int i = 0; i < curves.key_segments; ++i) {
    const std::string where = absl::StrCat("later_points[", i, "]");
    const auto points = array_of<float>(blobs, message.later_points(i), "points", 4);
    if (!points.ok()) return located(points.status(), where);
    if (points->size() != 4 * count) {
      return located(absl::InvalidArgumentError(absl::StrCat("it has ", points->size() / 4,
                                                             " control points where `points` has ", count)),
                     where);
    }
    if (!place_points(*points, placed_from_object, curves))
      return located(absl::InvalidArgumentError(kUnusablePoint), where);
  }
  return absl::OkStatus();
}

bool place_normals(const std::vector<float>& values, const Transform& object_from_placed,
                   CurvesRecord& curves) {
  const auto& m = object_from_placed.m;
  curves.normals.reserve(values.size() + 1);
  for (std::size_t i = 0; i < values.size(); i += 3) {
    const double x = values[i], y = values[i + 1], z = values[i + 2];
    const Imath::V3d n{m[0] * x + m[4] * y + m[8] * z, m[1] * x + m[5] * y + m[9] * z,
                       m[2] * x + m[6] * y + m[10] * z};
    const double l = n.length();
    if (!(l > 0) || !std::isfinite(l)) return false;
    for (const double c : {n.x, n.y, n.z}) curves.normals.push_back(static_cast<float>(c / l));
  }
  curves.normals.push_back(0);
  return true;
}

}  // namespace

absl::StatusOr<CurvesRecord> read_curves(const v1::Shape& shape, const Transform& placed_from_object,
                                         const BlobSource& blobs) {
  const v1::Curves& message = shape.curves();
  auto points = array_of<float>(blobs, message.points(), "points", 4);
  if (!points.ok()) return points.status();
  auto starts = array_of<std::uint32_t>(blobs, message.starts(), "segments", 1);
  if (!starts.ok()) return starts.status();
  CurvesRecord curves;
  curves.kind = message.kind() == v1::Curves::RIBBON     ? CurveKind::kRibbon
                : message.kind() == v1::Curves::CYLINDER ? CurveKind::kCylinder
                                                         : CurveKind::kFlat;
  curves.bspline = message.basis() == v1::Curves::BSPLINE;
  curves.starts = *std::move(starts);
  const std::size_t count = points->size() / 4;
  if (curves.starts.empty() || count > kMostPoints || curves.starts.size() > kMostPoints) {
    return absl::InvalidArgumentError(
        absl::StrCat("curves have 1 to ", kMostPoints, " segments and control points"));
  }
  for (const std::uint32_t start : curves.starts) {
    if (count < 4 || start > count - 4) {
      return absl::InvalidArgumentError(
          absl::StrCat("a segment begins at control point ", start, " of ", count));
    }
  }
  if (!place_points(*points, placed_from_object, curves)) return absl::InvalidArgumentError(kUnusablePoint);
  if (auto s = append_keys(message, placed_from_object, blobs, curves); !s.ok()) return s;
  if (curves.kind == CurveKind::kRibbon) {
    auto normals = array_of<float>(blobs, message.normals(), "normals", 3);
    if (!normals.ok()) return normals.status();
    Transform object_from_placed;
    if (normals->size() != 3 * count || !placed_from_object.invert(object_from_placed) ||
        !place_normals(*normals, object_from_placed, curves)) {
      return absl::InvalidArgumentError("a ribbon takes one usable normal for each of its control points");
    }
  }
  if (!message.params().digest().empty()) {
    auto params = array_of<float>(blobs, message.params(), "parameters", 2);
    if (!params.ok()) return params.status();
    curves.params = *std::move(params);
    if (curves.params.size() != 2 * curves.starts.size()) {
      return absl::InvalidArgumentError("its curves have another number of parameters than segments");
    }
  }
  return curves;
}

std::span<const ShapeKindRow> curve_kinds() {
  static constexpr ShapeKindRow kCurves{
      .message = v1::Shape::kCurves,
      .add =
          [](const ShapeToAdd& wanted) {
            auto curves = read_curves(wanted.shape, wanted.placed_from_object, wanted.blobs);
            if (!curves.ok()) return curves.status();
            curves->pieces = pieces_of(*curves);
            wanted.record.kind = ShapeKind::kCurves;
            if (curves->key_segments > 0) wanted.record.flags |= kDeforms;
            wanted.record.quadric = static_cast<std::int32_t>(wanted.table.curves.size());
            wanted.table.curves.push_back(*std::move(curves));
            return absl::OkStatus();
          },
      .why_open = [](const v1::Shape&) { return "curves are not closed"; }};
  return {&kCurves, 1};
}

}  // namespace tessera::render
