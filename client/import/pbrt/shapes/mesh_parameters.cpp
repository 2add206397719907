#include "import/pbrt/shapes/mesh_parameters.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "import/input/concat.h"
#include "import/pbrt/shapes/subdivision.h"

namespace tessera::client::pbrt {

std::vector<float> read_array(ValueReader& values, std::string_view name,
                              std::initializer_list<ParameterType> types) {
  const Parameter* parameter = values.parameters().find(name, types, values.diagnostics());
  if (parameter == nullptr) return {};
  std::vector<float> array(parameter->numbers.begin(), parameter->numbers.end());
  const auto bad = std::find_if(array.begin(), array.end(), [](float v) { return !std::isfinite(v); });
  if (bad != array.end()) {
    values.diagnostics().error(parameter->where,
                               concat("parameter \"", name, "\" of ", values.parameters().owner(), ": value ",
                                      bad - array.begin(), " does not fit a float"));
  }
  return array;
}

namespace {

/// P, N and uv, which must fit one another.
bool read_vertices(ValueReader& values, wire::MeshData& mesh) {
  mesh.positions = read_array(values, "P", {ParameterType::kPoint3});
  mesh.normals = read_array(values, "N", {ParameterType::kNormal});
  mesh.uvs = read_array(values, "uv", {ParameterType::kPoint2});
  const std::size_t vertices = mesh.positions.size() / 3;
  if (vertices == 0) return fail(values, "expected vertex positions \"point3 P\"");
  if (!mesh.normals.empty() && mesh.normals.size() != 3 * vertices) {
    return fail(values,
                concat("there are ", mesh.normals.size() / 3, " normals for ", vertices, " vertices"));
  }
  if (!mesh.uvs.empty() && mesh.uvs.size() != 2 * vertices) {
    return fail(values, concat("there are ", mesh.uvs.size() / 2, " \"uv\" for ", vertices, " vertices"));
  }
  return true;
}

/// "indices" in groups of `group`; without them, the vertices in order when they are just one group.
std::optional<std::vector<std::uint32_t>> read_indices(ValueReader& values, std::size_t vertices,
                                                       std::size_t group) {
  const Parameter* parameter =
      values.parameters().find("indices", {ParameterType::kInteger}, values.diagnostics());
  std::vector<std::uint32_t> indices;
  if (parameter == nullptr) {
    for (std::size_t i = 0; i < group; ++i) indices.push_back(static_cast<std::uint32_t>(i));
    if (vertices == group) return indices;
    fail(values, concat("expected \"integer indices\", because there are ", vertices, " vertices"));
    return std::nullopt;
  }
  if (parameter->numbers.size() % group != 0) {
    values.diagnostics().error(parameter->where, concat("expected a multiple of ", group, " indices, found ",
                                                        parameter->numbers.size()));
    return std::nullopt;
  }
  indices.reserve(parameter->numbers.size());
  for (std::size_t i = 0; i < parameter->numbers.size(); ++i) {
    const double index = parameter->numbers[i];
    if (!(index >= 0) || index >= static_cast<double>(vertices)) {
      values.diagnostics().error(
          parameter->where,
          concat("index ", index, " (number ", i, ") is out of range: there are ", vertices, " vertices"));
      return std::nullopt;
    }
    indices.push_back(static_cast<std::uint32_t>(index));
  }
  return indices;
}

}  // namespace

std::optional<wire::MeshData> read_triangle_mesh(ValueReader& values) {
  wire::MeshData mesh;
  if (!read_vertices(values, mesh)) return std::nullopt;
  std::optional<std::vector<std::uint32_t>> indices = read_indices(values, mesh.positions.size() / 3, 3);
  if (!indices) return std::nullopt;
  mesh.indices = *std::move(indices);
  // Tangents only orient anisotropic materials, which take theirs from (u, v); face indices serve ptex.
  if (values.parameters().has("S"))
    values.warn("\"S\" of a trianglemesh is ignored: tangents follow from (u, v)");
  values.parameters().ignore({"S", "faceIndices"});
  return mesh;
}

std::optional<BilinearTessellation> read_bilinear_mesh(ValueReader& values) {
  wire::MeshData corners;
  if (!read_vertices(values, corners)) return std::nullopt;
  std::optional<std::vector<std::uint32_t>> indices = read_indices(values, corners.positions.size() / 3, 4);
  if (!indices) return std::nullopt;
  if (values.parameters().has("emissionfilename")) {
    values.warn("\"emissionfilename\" of a bilinearmesh is not supported: it emits evenly");
  }
  values.parameters().ignore({"faceIndices", "emissionfilename"});
  BilinearTessellation triangles = tessellate_patches(corners, *indices);
  if (triangles.curved) {
    values.warn(concat("curved bilinear patches are cut into ", triangles.steps, " x ", triangles.steps,
                       " cells each"));
  }
  return triangles;
}

std::optional<wire::MeshData> read_subdivision_mesh(ValueReader& values) {
  constexpr std::int64_t kMostTriangles = std::int64_t{1} << 26;
  wire::MeshData control;
  control.positions = read_array(values, "P", {ParameterType::kPoint3});
  if (control.positions.empty()) {
    fail(values, "expected vertex positions \"point3 P\"");
    return std::nullopt;
  }
  std::optional<std::vector<std::uint32_t>> indices = read_indices(values, control.positions.size() / 3, 3);
  if (!indices) return std::nullopt;
  control.indices = *std::move(indices);
  const std::int64_t levels = values.get_integer("levels", 3);
  values.parameters().ignore({"scheme"});
  const auto faces = static_cast<std::int64_t>(control.indices.size() / 3);
  if (levels < 0 || levels > 13 || faces > (kMostTriangles >> (2 * levels))) {
    fail(values, concat(levels, " levels of ", faces, " faces are not possible: at most ", kMostTriangles,
                        " triangles may come out"));
    return std::nullopt;
  }
  std::optional<wire::MeshData> smooth = subdivide_loop(control, static_cast<int>(levels));
  if (!smooth)
    fail(values, "its faces do not fit one another: an edge has more than two, or two of the same direction");
  return smooth;
}

}  // namespace tessera::client::pbrt
