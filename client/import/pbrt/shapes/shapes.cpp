#include "import/pbrt/shapes/shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "import/input/concat.h"
#include "import/pbrt/shapes/implicit.h"
#include "import/pbrt/shapes/mesh_parameters.h"
#include "import/pbrt/shapes/solids.h"

namespace tessera::client::pbrt {
namespace {

void add_mesh(ValueReader& values, wire::MeshData mesh, v1::Shape& shape) {
  turn_faces_to_normals(mesh);
  *shape.mutable_mesh()->mutable_blob() = values.context().blobs.add_bytes(wire::encode_mesh(mesh));
}

ShapeResult write_triangle_mesh(ValueReader& values, v1::Shape& shape) {
  std::optional<wire::MeshData> mesh = read_triangle_mesh(values);
  if (!mesh) return {};
  add_mesh(values, *std::move(mesh), shape);
  return {true, "", ""};
}

ShapeResult write_bilinear_mesh(ValueReader& values, v1::Shape& shape) {
  std::optional<BilinearTessellation> triangles = read_bilinear_mesh(values);
  if (!triangles) return {};
  add_mesh(values, std::move(triangles->mesh), shape);
  const auto steps = static_cast<std::size_t>(triangles->steps);
  return {true, "", "", 2 * steps * steps};
}

ShapeResult write_subdivision(ValueReader& values, v1::Shape& shape) {
  std::optional<wire::MeshData> mesh = read_subdivision_mesh(values);
  if (!mesh) return {};
  add_mesh(values, *std::move(mesh), shape);
  return {true, "", ""};
}

ShapeResult write_ply_mesh(ValueReader& values, v1::Shape&) {
  ShapeResult result;
  result.ply_file = values.get_string("filename", "");
  if (result.ply_file.empty()) {
    values.diagnostics().error(values.parameters().where(),
                               "shape \"plymesh\": expected \"string filename\"");
    return {};
  }
  if (values.parameters().has("displacement")) {
    values.warn("\"displacement\" of shape \"plymesh\" is not supported yet: the mesh is not displaced");
  }
  values.parameters().ignore({"displacement", "edgelength", "displacement.uvscale"});
  result.kept = true;
  return result;
}

ShapeResult write_sphere(ValueReader& values, v1::Shape& shape) {
  v1::Sphere& sphere = *shape.mutable_sphere();
  const double radius = values.get_float("radius", 1);
  sphere.set_radius(static_cast<float>(radius));
  if (!(radius > 0)) {
    values.diagnostics().error(values.parameters().where(),
                               concat("shape \"sphere\": radius ", radius, " is not above 0"));
  }
  const double z_first = values.get_float("zmin", -radius), z_second = values.get_float("zmax", radius);
  const double z_min = std::min(z_first, z_second), z_max = std::max(z_first, z_second);
  const double phi_max = values.get_float("phimax", 360);
  if (z_min > -radius) sphere.set_z_min(static_cast<float>(std::min(z_min, radius)));
  if (z_max < radius) sphere.set_z_max(static_cast<float>(std::max(z_max, -radius)));
  if (phi_max < 360) sphere.set_phi_max_degrees(static_cast<float>(std::max(phi_max, 0.0)));
  return {true, "", ""};
}

ShapeResult write_disk(ValueReader& values, v1::Shape& shape) {
  v1::Disk& disk = *shape.mutable_disk();
  disk.set_radius(static_cast<float>(values.get_float("radius", 1)));
  disk.set_inner_radius(static_cast<float>(values.get_float("innerradius", 0)));
  disk.set_height(static_cast<float>(values.get_float("height", 0)));
  const double phi_max = values.get_float("phimax", 360);
  if (phi_max < 360) disk.set_phi_max_degrees(static_cast<float>(std::max(phi_max, 0.0)));
  if (!(disk.radius() > disk.inner_radius()) || disk.inner_radius() < 0) {
    values.diagnostics().error(values.parameters().where(),
                               "shape \"disk\": expected 0 <= innerradius < radius");
  }
  return {true, "", ""};
}

ShapeResult write_cylinder(ValueReader& values, v1::Shape& shape) {
  v1::Cylinder& cylinder = *shape.mutable_cylinder();
  const double z_first = values.get_float("zmin", -1), z_second = values.get_float("zmax", 1);
  cylinder.set_radius(static_cast<float>(values.get_float("radius", 1)));
  cylinder.set_z_min(static_cast<float>(std::min(z_first, z_second)));
  cylinder.set_z_max(static_cast<float>(std::max(z_first, z_second)));
  cylinder.set_capped(values.get_bool("capped", false));
  const double phi_max = values.get_float("phimax", 360);
  if (phi_max < 360) cylinder.set_phi_max_degrees(static_cast<float>(std::max(phi_max, 0.0)));
  if (!(cylinder.radius() > 0) || !(cylinder.z_min() < cylinder.z_max())) {
    values.diagnostics().error(values.parameters().where(),
                               "shape \"cylinder\": expected radius > 0 and zmin < zmax");
  }
  return {true, "", ""};
}

struct ShapeType {
  std::string_view name;
  ShapeResult (*write)(ValueReader& values, v1::Shape& shape);
};

constexpr ShapeType kShapeTypes[] = {{"trianglemesh", write_triangle_mesh},
                                     {"plymesh", write_ply_mesh},
                                     {"sphere", write_sphere},
                                     {"disk", write_disk},
                                     {"bilinearmesh", write_bilinear_mesh},
                                     {"loopsubdiv", write_subdivision},
                                     {"cylinder", write_cylinder},
                                     {"halfspace", write_half_space},
                                     {"cone", write_cone},
                                     {"polygon", write_polygon},
                                     {"box", write_box},
                                     {"polyhedron", write_polyhedron},
                                     {"torus", write_torus},
                                     {"ellipsoid", write_ellipsoid},
                                     {"implicit", write_implicit}};

/// Area of all triangles, and whether each has the same.
SurfaceArea mesh_area(const wire::MeshView& mesh, const Imath::M44d& world_from_object) {
  SurfaceArea area;
  double smallest = HUGE_VAL, largest = 0;
  const auto vertex = [&](std::uint32_t index) {
    const float* p = &mesh.positions[3 * std::size_t{index}];
    return Imath::V3d(p[0], p[1], p[2]) * world_from_object;
  };
  for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
    const Imath::V3d a = vertex(mesh.indices[t]), b = vertex(mesh.indices[t + 1]),
                     c = vertex(mesh.indices[t + 2]);
    const double u[] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    const double one =
        std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2;
    area.total += one;
    smallest = std::min(smallest, one);
    largest = std::max(largest, one);
  }
  area.triangles = mesh.indices.size() / 3;
  area.triangles_of_equal_area =
      largest - smallest <= 1e-4 * largest;  // the roundings of vertices given with five digits
  return area;
}

}  // namespace

void finish_shape(ValueReader& values, v1::Shape& shape, ShapeResult& result) {
  const Parameter* alpha = values.parameters().find("alpha", {ParameterType::kFloat, ParameterType::kTexture},
                                                    values.diagnostics());
  if (alpha != nullptr && alpha->type == ParameterType::kTexture && !alpha->strings.empty()) {
    result.alpha_texture = alpha->strings.front();
  } else if (alpha != nullptr) {
    shape.mutable_alpha()->set_constant(static_cast<float>(values.get_float("alpha", 1)));
  }
}

ShapeResult write_shape(const std::string& type, ValueReader& values, v1::Shape& shape) {
  for (const ShapeType& known : kShapeTypes) {
    if (known.name != type) continue;
    ShapeResult result = known.write(values, shape);
    if (result.kept) finish_shape(values, shape, result);
    return result;
  }
  std::string names;
  for (const ShapeType& known : kShapeTypes) names += concat(known.name, ", ");
  values.diagnostics().error(values.parameters().where(),
                             concat("unknown shape \"", type, "\": expected ", names, "or curve"));
  return {};
}

SurfaceArea world_area(const v1::Shape& shape, const Imath::M44d& world_from_object,
                       const BlobCollector& blobs) {
  const double uniform_scale_squared = std::pow(std::abs(determinant3(world_from_object)), 2.0 / 3.0);
  const auto radians = [](bool given, float degrees) {
    return (given ? degrees : 360) * std::numbers::pi / 180;
  };
  switch (shape.kind_case()) {
    case v1::Shape::kMesh: {
      const SceneBlob* blob = blobs.find(shape.mesh().blob().digest());
      if (blob == nullptr) return {};
      const absl::StatusOr<wire::MeshView> mesh = wire::decode_mesh(blob->bytes);
      return mesh.ok() ? mesh_area(*mesh, world_from_object) : SurfaceArea{};
    }
    case v1::Shape::kSphere: {
      const v1::Sphere& s = shape.sphere();
      const double height =
          (s.has_z_max() ? s.z_max() : s.radius()) - (s.has_z_min() ? s.z_min() : -s.radius());
      return {uniform_scale_squared * radians(s.has_phi_max_degrees(), s.phi_max_degrees()) * s.radius() *
              height};
    }
    case v1::Shape::kDisk: {
      const v1::Disk& d = shape.disk();
      return {uniform_scale_squared * radians(d.has_phi_max_degrees(), d.phi_max_degrees()) / 2 *
              (d.radius() * d.radius() - d.inner_radius() * d.inner_radius())};
    }
    case v1::Shape::kCylinder: {
      const v1::Cylinder& c = shape.cylinder();
      return {uniform_scale_squared * radians(c.has_phi_max_degrees(), c.phi_max_degrees()) * c.radius() *
              (c.z_max() - c.z_min())};
    }
    case v1::Shape::kBox:
    case v1::Shape::kPolygon:
      return {area_of_flat(shape, world_from_object)};
    default:
      return {};
  }
}

void turn_faces_to_normals(wire::MeshData& mesh) {
  if (mesh.normals.empty()) return;
  for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
    const float* p[3];
    const float* n[3];
    for (int k = 0; k < 3; ++k) {
      p[k] = &mesh.positions[3 * std::size_t{mesh.indices[t + k]}];
      n[k] = &mesh.normals[3 * std::size_t{mesh.indices[t + k]}];
    }
    const float u[] = {p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2]};
    const float v[] = {p[2][0] - p[0][0], p[2][1] - p[0][1], p[2][2] - p[0][2]};
    const float face[] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    float agreement = 0;
    for (int a = 0; a < 3; ++a) agreement += face[a] * (n[0][a] + n[1][a] + n[2][a]);
    if (agreement < 0) std::swap(mesh.indices[t + 1], mesh.indices[t + 2]);
  }
}

}  // namespace tessera::client::pbrt
