#include "import/pbrt/shapes/curves.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "import/input/concat.h"

namespace tessera::client::pbrt {
namespace {

using Points = std::vector<Imath::V3d>;

Imath::V3d mix(const Imath::V3d& a, const Imath::V3d& b, double t) { return (1 - t) * a + t * b; }

Points read_points(ValueReader& values, std::string_view name, ParameterType type) {
  const Parameter* parameter = values.parameters().find(name, {type}, values.diagnostics());
  Points points(parameter == nullptr ? 0 : parameter->numbers.size() / 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = {parameter->numbers[3 * i], parameter->numbers[3 * i + 1], parameter->numbers[3 * i + 2]};
  }
  return points;
}

/// The same quadratic as a cubic.
void add_elevated(const Imath::V3d& a, const Imath::V3d& b, const Imath::V3d& c, Points& out) {
  out.insert(out.end(), {a, mix(a, b, 2.0 / 3), mix(b, c, 1.0 / 3), c});
}

/// Segment `s` of uniform B-splines and of Bezier splines, as four Bezier points each. Polar forms of a
/// uniform B-spline [Ramshaw 1989].
void add_segment(const Points& p, std::size_t s, bool bspline, int degree, Points& out) {
  if (!bspline && degree == 3) {
    out.insert(out.end(), p.begin() + static_cast<std::ptrdiff_t>(3 * s),
               p.begin() + static_cast<std::ptrdiff_t>(3 * s + 4));
  } else if (!bspline) {
    add_elevated(p[2 * s], p[2 * s + 1], p[2 * s + 2], out);
  } else if (degree == 2) {
    add_elevated(mix(p[s], p[s + 1], 0.5), p[s + 1], mix(p[s + 1], p[s + 2], 0.5), out);
  } else {
    const Imath::V3d b1 = mix(p[s + 1], p[s + 2], 1.0 / 3), b2 = mix(p[s + 1], p[s + 2], 2.0 / 3);
    const Imath::V3d before = mix(p[s], p[s + 1], 2.0 / 3), after = mix(p[s + 2], p[s + 3], 1.0 / 3);
    out.insert(out.end(), {mix(before, b1, 0.5), b1, b2, mix(b2, after, 0.5)});
  }
}

/// How many segments the control points make; 0 where they do not fit.
std::size_t count_segments(std::size_t points, bool bspline, std::size_t degree) {
  if (points < degree + 1) return 0;
  if (bspline) return points - degree;
  return (points - 1) % degree == 0 ? (points - 1) / degree : 0;
}

/// Between two unit normals, along the great arc.
Imath::V3d turned(const Imath::V3d& a, const Imath::V3d& b, double t) {
  const double cosine = std::clamp(a[0] * b[0] + a[1] * b[1] + a[2] * b[2], -1.0, 1.0);
  const double angle = std::acos(cosine), sine = std::sin(angle);
  if (sine < 1e-6) return mix(a, b, t);
  const double wa = std::sin((1 - t) * angle) / sine, wb = std::sin(t * angle) / sine;
  return wa * a + wb * b;
}

bool read_normals(ValueReader& values, std::size_t segments, Points& normals) {
  normals = read_points(values, "N", ParameterType::kNormal);
  if (normals.size() != segments + 1) {
    return fail(values, concat("a ribbon of ", segments, " segments takes ", segments + 1,
                               " normals \"N\", found ", normals.size()));
  }
  for (Imath::V3d& n : normals) {
    const double size = length(n);
    if (!(size > 0) || !std::isfinite(size)) return fail(values, "a normal has no direction");
    n /= size;
  }
  return true;
}

template <typename T>
std::string bytes_of(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

}  // namespace

v1::Curves::Kind read_curve_kind(ValueReader& values) {
  const std::string type = values.get_string("type", "flat");
  if (type == "ribbon") return v1::Curves::RIBBON;
  if (type == "cylinder") return v1::Curves::CYLINDER;
  if (type != "flat") fail(values, concat("unknown type \"", type, "\": expected flat, cylinder or ribbon"));
  return v1::Curves::FLAT;
}

bool append_curve(ValueReader& values, CurveBatch& batch) {
  const std::string basis = values.get_string("basis", "bezier");
  const std::int64_t degree = values.get_integer("degree", 3);
  const double width = values.get_float("width", 1);
  const double width0 = values.get_float("width0", width), width1 = values.get_float("width1", width);
  const Points control = read_points(values, "P", ParameterType::kPoint3);
  // How finely pbrt cuts a curve up for its own tree.
  values.parameters().ignore({"splitdepth", "width"});
  if (batch.kind != v1::Curves::RIBBON) values.parameters().ignore({"N"});
  if (basis != "bezier" && basis != "bspline") {
    return fail(values, concat("unknown basis \"", basis, "\": expected bezier or bspline"));
  }
  if (degree != 2 && degree != 3) return fail(values, concat("expected degree 2 or 3, found ", degree));
  if (!(width0 >= 0) || !(width1 >= 0)) return fail(values, "a width is below 0");
  const bool bspline = basis == "bspline";
  const std::size_t segments = count_segments(control.size(), bspline, static_cast<std::size_t>(degree));
  if (segments == 0) {
    return fail(values,
                concat(control.size(), " control points \"P\" do not fit a ", basis, " of degree ", degree));
  }
  Points normals;
  if (batch.kind == v1::Curves::RIBBON && !read_normals(values, segments, normals)) return false;

  Points bezier;
  for (std::size_t s = 0; s < segments; ++s) {
    bezier.clear();
    add_segment(control, s, bspline, static_cast<int>(degree), bezier);
    // The last point of a segment is the first of the next.
    batch.starts.push_back(static_cast<std::uint32_t>(batch.points.size() / 4 - (s > 0 ? 1 : 0)));
    for (int k = s == 0 ? 0 : 1; k < 4; ++k) {
      const double along = (static_cast<double>(s) + k / 3.0) / static_cast<double>(segments);
      append_floats(batch.points, bezier[static_cast<std::size_t>(k)]);
      batch.points.push_back(static_cast<float>(((1 - along) * width0 + along * width1) / 2));
      if (!normals.empty()) append_floats(batch.normals, turned(normals[s], normals[s + 1], k / 3.0));
    }
  }
  return true;
}

void append(const CurveBatch& more, CurveBatch& batch) {
  const auto first = static_cast<std::uint32_t>(batch.points.size() / 4);
  for (const std::uint32_t start : more.starts) batch.starts.push_back(first + start);
  batch.points.insert(batch.points.end(), more.points.begin(), more.points.end());
  batch.normals.insert(batch.normals.end(), more.normals.begin(), more.normals.end());
}

void write_curves(const CurveBatch& batch, BlobCollector& blobs, v1::Curves& curves) {
  curves.set_kind(batch.kind);
  curves.set_basis(v1::Curves::BEZIER);
  *curves.mutable_points() = blobs.add_bytes(bytes_of(batch.points));
  *curves.mutable_starts() = blobs.add_bytes(bytes_of(batch.starts));
  if (batch.kind == v1::Curves::RIBBON) *curves.mutable_normals() = blobs.add_bytes(bytes_of(batch.normals));
}

}  // namespace tessera::client::pbrt
