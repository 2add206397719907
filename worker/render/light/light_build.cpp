#include "render/light/light_build.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "render/light/area/rectangle_build.h"
#include "render/light/light_source.h"

namespace tessera::render {
namespace {

using namespace vec64;

Vec column(const Affine& a, int c) { return {a.m[c], a.m[4 + c], a.m[8 + c]}; }

void describe_triangle(const ShapeTable& table, const ShapeRecord& shape, LightRecord& light) {
  light.kind = LightKind::kTriangle;
  const auto triangle = static_cast<std::size_t>(shape.first_triangle + light.primitive);
  Vec p[3];
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const std::size_t vertex =
        static_cast<std::size_t>(shape.first_vertex) + table.triangles[triangle * 3 + corner];
    for (std::size_t i = 0; i < 3; ++i)
      p[corner][i] = light.vertices[corner * 3 + i] = table.vertices[vertex].position[i];
  }
  const Vec e1 = {p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2]};
  const Vec e2 = {p[2][0] - p[0][0], p[2][1] - p[0][1], p[2][2] - p[0][2]};
  light.area = static_cast<float>(0.5 * length(cross(e1, e2)));
}

/// Whether the normals at the corners of a triangle light turn away from its own by more than roundings.
bool is_smooth(const ShapeTable& table, const ShapeRecord& shape, const LightRecord& light) {
  if (!(shape.flags & kHasNormals)) return false;
  const auto triangle = static_cast<std::size_t>(shape.first_triangle + light.primitive);
  const float* v = light.vertices;
  const Vec n = cross({double{v[3]} - v[0], double{v[4]} - v[1], double{v[5]} - v[2]},
                      {double{v[6]} - v[0], double{v[7]} - v[1], double{v[8]} - v[2]});
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const std::size_t vertex =
        static_cast<std::size_t>(shape.first_vertex) + table.triangles[triangle * 3 + corner];
    const float* at = table.vertices[vertex].normal;
    const Vec normal = {at[0], at[1], at[2]};
    if (length(cross(n, normal)) > 1e-4 * length(n) * length(normal)) return true;
  }
  return false;
}

void describe_triangles(const ShapeTable& shapes, const ShapeRecord& record, float interpolated_pick,
                        LightRecord light, std::vector<LightRecord>& lights) {
  const std::size_t first = lights.size();
  double area = 0;
  for (light.primitive = 0; light.primitive < record.triangle_count; ++light.primitive) {
    describe_triangle(shapes, record, light);
    area += light.area;
    const bool smooth = interpolated_pick > 0 && is_smooth(shapes, record, light);
    light.profile = smooth ? kInterpolated : kPlainProfile;
    lights.push_back(light);
    if (light.primitive > 0 && !smooth && lights.end()[-2].profile == kPlainProfile)
      merge_into_rectangle(lights.end()[-2], static_cast<std::int32_t>(lights.size()) - 2, lights.back());
  }
  for (std::size_t i = first; i < lights.size(); ++i) {
    if (lights[i].profile != kInterpolated) continue;
    lights[i].tan_x = interpolated_pick;
    lights[i].tan_y = static_cast<float>(area);
  }
}

/// Area of a cylinder's wall under any affine map.
double cylinder_area(const QuadricRecord& q) {
  const Vec x = column(q.render_from_object, 0), y = column(q.render_from_object, 1),
            z = column(q.render_from_object, 2);
  constexpr int kSteps = 1024;
  double around = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double phi = (i + 0.5) / kSteps * q.phi_max;
    Vec along;
    for (std::size_t c = 0; c < 3; ++c) along[c] = std::cos(phi) * y[c] - std::sin(phi) * x[c];
    around += length(cross(along, z));
  }
  return around / kSteps * q.phi_max * q.radius * (double{q.z_max} - q.z_min);
}

double disk_area(const QuadricRecord& q) {
  const double in_object =
      0.5 * q.phi_max * (double{q.radius} * q.radius - double{q.inner_radius} * q.inner_radius);
  return in_object * length(cross(column(q.render_from_object, 0), column(q.render_from_object, 1)));
}

/// The factor by which an affine map scales every direction, 0 when it is not one factor (to a part in 10^4).
double similarity_scale(const Affine& a) {
  const Vec x = column(a, 0), y = column(a, 1), z = column(a, 2);
  const double scale = length(x);
  const double skew =
      std::max({std::abs(length(y) - scale), std::abs(length(z) - scale), std::abs(dot(x, y)) / scale,
                std::abs(dot(x, z)) / scale, std::abs(dot(y, z)) / scale});
  return skew <= 1e-4 * scale ? scale : 0;
}

/// Area of a zone of a sphere under any affine map, by quadrature where there is no closed form.
double sphere_area(const QuadricRecord& q) {
  const double zone = double{q.radius} * q.phi_max * (double{q.z_max} - q.z_min);
  const Affine& m = q.render_from_object;
  const Vec x = column(m, 0), y = column(m, 1), z = column(m, 2);
  if (const double scale = similarity_scale(m); scale > 0) return zone * scale * scale;
  // Areas scale by |cofactor(M) n|, whose columns are these.
  const Vec cx = cross(y, z), cy = cross(z, x), cz = cross(x, y);
  constexpr int kSteps = 128;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double nz = (q.z_min + (i + 0.5) / kSteps * (double{q.z_max} - q.z_min)) / q.radius;
    const double r = std::sqrt(std::max(0.0, 1 - nz * nz));
    for (int j = 0; j < kSteps; ++j) {
      const double phi = (j + 0.5) / kSteps * q.phi_max;
      const double nx = r * std::cos(phi), ny = r * std::sin(phi);
      Vec n;
      for (std::size_t c = 0; c < 3; ++c) n[c] = nx * cx[c] + ny * cy[c] + nz * cz[c];
      sum += length(n);
    }
  }
  return zone * sum / (kSteps * kSteps);
}

void describe_sphere(const QuadricRecord& q, LightRecord& light) {
  light.kind = LightKind::kSphere;
  light.area = static_cast<float>(sphere_area(q));
  const auto& m = q.render_from_object.m;
  light.position[0] = m[3];
  light.position[1] = m[7];
  light.position[2] = m[11];
  light.radius = q.partial ? 0.0f : static_cast<float>(q.radius * similarity_scale(q.render_from_object));
}

}  // namespace

void append_area_lights(ShapeTable& shapes, std::int32_t shape, std::span<const float, 3> radiance,
                        bool two_sided, std::int32_t texture, std::vector<LightRecord>& lights,
                        float interpolated_pick) {
  ShapeRecord& record = shapes.shapes[static_cast<std::size_t>(shape)];
  record.first_light = static_cast<std::int32_t>(lights.size());
  LightRecord light;
  light.shape = shape;
  light.two_sided = two_sided;
  light.texture = texture;
  std::copy(radiance.begin(), radiance.end(), light.radiance);
  switch (record.kind) {
    case ShapeKind::kTriangles:
      describe_triangles(shapes, record, interpolated_pick, light, lights);
      return;
    case ShapeKind::kSphere:
      describe_sphere(shapes.quadrics[static_cast<std::size_t>(record.quadric)], light);
      break;
    case ShapeKind::kDisk:
      light.kind = LightKind::kDisk;
      light.area = static_cast<float>(disk_area(shapes.quadrics[static_cast<std::size_t>(record.quadric)]));
      break;
    case ShapeKind::kCylinder:
      light.kind = LightKind::kCylinder;
      light.area =
          static_cast<float>(cylinder_area(shapes.quadrics[static_cast<std::size_t>(record.quadric)]));
      break;
    case ShapeKind::kSdfGrid:
    case ShapeKind::kCurves:
    case ShapeKind::kCount:
      return;  // build/ lets none of these emit
  }
  lights.push_back(light);
}

double sampled_power(const LightTable& table, const LightRecord& light) {
  if (light.same_as >= 0) return 0;
  const double share = light.environment >= 0
                           ? table.environments[static_cast<std::size_t>(light.environment)].sampled_share
                           : 1;
  const double power = share * table.sources(light.kind).power(table, light);
  return std::isfinite(power) && power > 0 ? power : 0;
}

AliasTable selection_of_lights(const LightTable& table, LightSelection kind) {
  AliasTable none;
  none.pmf.assign(table.lights.size(), 0.0f);
  if (kind == LightSelection::kNone) return none;
  // Most choices by power, some evenly among emitters: power alone starves a lamp beside a bright sky, whose
  // power grows with the scene's size. Measured: docs/decisions/0006-media-and-passing.md.
  const double by_power = kind == LightSelection::kPower ? 1 : kind == LightSelection::kUniform ? 0 : 0.75;
  std::vector<double> power;
  std::map<std::pair<std::int32_t, std::size_t>, double> emitters;  // a shape, or a light without one
  const auto emitter_of = [&](std::size_t i) {
    const std::int32_t shape = table.lights[i].shape;
    return std::pair{shape, shape >= 0 ? std::size_t{0} : i};
  };
  double total = 0;
  for (std::size_t i = 0; i < table.lights.size(); ++i) {
    power.push_back(sampled_power(table, table.lights[i]));
    total += power.back();
    emitters[emitter_of(i)] += power.back();
  }
  if (total == 0) return none;
  const auto shining = static_cast<double>(std::count_if(
      emitters.begin(), emitters.end(), [](const auto& emitter) { return emitter.second > 0; }));
  std::vector<double> weights(power.size(), 0);
  for (std::size_t i = 0; i < power.size(); ++i) {
    if (power[i] > 0)
      weights[i] =
          by_power * power[i] / total + (1 - by_power) / shining * power[i] / emitters[emitter_of(i)];
  }
  AliasTable selection = AliasTable::build(weights);
  for (std::size_t i = 0; i < power.size(); ++i) {
    if (const std::int32_t other = table.lights[i].same_as; other >= 0)
      selection.pmf[i] = selection.pmf[static_cast<std::size_t>(other)];
  }
  return selection;
}

}  // namespace tessera::render
