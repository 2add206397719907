#include "import/gltf/shapes/primitives.h"

#include <algorithm>
#include <cmath>

namespace tessera::client::gltf {
namespace {

constexpr int kTriangles = 4, kStrip = 5, kFan = 6;

/// Corners of separate triangles, out of those of a strip or fan.
std::vector<std::uint32_t> separate_triangles(const std::vector<std::uint32_t>& corners, int mode) {
  std::vector<std::uint32_t> result;
  for (std::size_t i = 0; i + 2 < corners.size(); i += mode == kTriangles ? 3 : 1) {
    if (mode == kFan) {
      result.insert(result.end(), {corners[i + 1], corners[i + 2], corners[0]});
    } else if (mode == kStrip && i % 2 == 1) {
      result.insert(result.end(), {corners[i + 1], corners[i], corners[i + 2]});
    } else {
      result.insert(result.end(), {corners[i], corners[i + 1], corners[i + 2]});
    }
  }
  return result;
}

}  // namespace

PrimitiveReader::Floats PrimitiveReader::attribute(const std::string& name) {
  const Json* attributes = member(json_, "attributes");
  const std::optional<std::size_t> index = index_of(attributes, name.c_str());
  if (!index) return std::nullopt;
  const Accessor& accessor = accessors_[*index];
  const std::string at = below(below(place_, "attributes"), name);
  if (is_compressed_) {
    const auto found = std::ranges::find(decoded_, name, &Decoded::name);
    if (found != decoded_.end()) return std::move(found->values);
  }
  if (accessor.count != vertex_count_) {
    context_.error(at, concat(accessor.count, " elements, where POSITION has ", vertex_count_));
    return std::nullopt;
  }
  return accessors_.read(*index);
}

std::optional<Primitive> PrimitiveReader::read(const Json& primitive, const std::string& place,
                                               int texture_set, const Deformation& deformation) {
  json_ = &primitive, place_ = place, is_compressed_ = false;
  decoded_.clear(), decoded_indices_.clear();
  const int mode = static_cast<int>(integer_of(json_, "mode", kTriangles));
  if (mode < kTriangles) {
    context_.warn(place, "points and lines are left out");
    return std::nullopt;
  }
  const std::optional<std::size_t> positions = index_of(member(json_, "attributes"), "POSITION");
  if (!positions) {
    context_.warn(place, "a primitive without POSITION is left out");
    return std::nullopt;
  }
  vertex_count_ = accessors_[*positions].count;
  constexpr const char* kDraco = "KHR_draco_mesh_compression";
  if (const Json* draco = extension(json_, kDraco);
      draco != nullptr && !decode_draco(*draco, below(below(place, "extensions"), kDraco)))
    return std::nullopt;
  Primitive result;
  if (!read_vertices(texture_set, result) || !read_indices(result)) return std::nullopt;
  if (!is_compressed_ || mode != kTriangles)
    result.mesh.indices = separate_triangles(result.mesh.indices, mode);
  if (result.mesh.indices.empty()) return std::nullopt;
  if (!morph(deformation.weights, result.mesh)) return std::nullopt;
  if (!deformation.world_from_joint.empty() && !bend(deformation.world_from_joint, result.mesh))
    return std::nullopt;
  return result;
}

bool PrimitiveReader::decode_draco(const Json& draco, const std::string& place) {
  const auto bytes = buffers_.view(*index_of(&draco, "bufferView"));
  if (!bytes) return false;
  std::vector<DracoAttribute> attributes;
  for (const auto& [name, id] : member(&draco, "attributes")->items()) {
    const auto index = index_of(member(json_, "attributes"), name.c_str());
    if (!id.is_number_unsigned() || !index) {
      context_.error(below(below(place, "attributes"), name),
                     "expected the id of an attribute that the primitive has");
      return false;
    }
    attributes.push_back({name, id.get<std::uint32_t>(), accessors_[*index].components, {}});
  }
  const std::string fault = decode_draco_mesh(*bytes, vertex_count_, attributes, decoded_indices_);
  if (!fault.empty()) {
    context_.error(place, fault);
    return false;
  }
  for (DracoAttribute& attribute : attributes) {
    const auto components = static_cast<std::size_t>(attribute.components);
    vertex_count_ = attribute.values.size() / std::max<std::size_t>(components, 1);
    decoded_.push_back({attribute.name, std::move(attribute.values)});
  }
  is_compressed_ = true;
  return true;
}

bool PrimitiveReader::read_vertices(int texture_set, Primitive& result) {
  Floats positions = attribute("POSITION");
  if (!positions) return false;
  result.mesh.positions = *std::move(positions);
  if (Floats normals = attribute("NORMAL")) result.mesh.normals = *std::move(normals);
  if (Floats uvs = attribute(concat("TEXCOORD_", texture_set))) {
    result.mesh.uvs = *std::move(uvs);
    for (std::size_t i = 1; i < result.mesh.uvs.size(); i += 2) result.mesh.uvs[i] = 1 - result.mesh.uvs[i];
  }
  read_colors(result);
  return !context_.diagnostics.has_errors();
}

void PrimitiveReader::read_colors(Primitive& result) {
  const auto index = index_of(member(json_, "attributes"), "COLOR_0");
  if (!index) return;
  const Floats colors = attribute("COLOR_0");
  if (!colors) return;
  const auto components = static_cast<std::size_t>(accessors_[*index].components);
  bool is_transparent = false;
  for (std::size_t i = 0; i < colors->size(); ++i) {
    const float value = std::clamp((*colors)[i], 0.0f, 1.0f);
    (i % components == 3 ? result.alphas : result.colors).push_back(value);
    is_transparent = is_transparent || (i % components == 3 && value < 1);
  }
  if (!is_transparent) result.alphas.clear();
}

bool PrimitiveReader::read_indices(Primitive& result) {
  std::vector<std::uint32_t>& indices = result.mesh.indices;
  const std::optional<std::size_t> index = index_of(json_, "indices");
  const std::string at = below(place_, "indices");
  if (is_compressed_) {
    indices = std::move(decoded_indices_);
  } else if (!index) {
    indices.resize(vertex_count_);
    for (std::size_t i = 0; i < vertex_count_; ++i) indices[i] = static_cast<std::uint32_t>(i);
  } else {
    const Accessor& accessor = accessors_[*index];
    const bool is_unsigned = accessor.component == Component::kUnsignedByte ||
                             accessor.component == Component::kUnsignedShort ||
                             accessor.component == Component::kUnsignedInt;
    if (accessor.components != 1 || !is_unsigned || accessor.normalized) {
      context_.error(at, concat("accessor ", *index, " is not of unsigned integers, one an element"));
      return false;
    }
    std::optional<std::vector<std::uint32_t>> read = accessors_.read_integers(*index);
    if (!read) return false;
    indices = *std::move(read);
  }
  const auto bad = std::ranges::find_if(indices, [&](std::uint32_t i) { return i >= vertex_count_; });
  if (bad == indices.end()) return true;
  context_.error(at, concat("element ", bad - indices.begin(), " is ", *bad, ", but there are ",
                            vertex_count_, " vertices"));
  return false;
}

bool PrimitiveReader::morph(const std::vector<double>& weights, wire::MeshData& mesh) {
  const std::size_t targets = size_of(json_, "targets");
  for (std::size_t t = 0; t < std::min(targets, weights.size()); ++t) {
    if (weights[t] == 0) continue;
    const Json* target = element(json_, "targets", t);
    for (const auto& [name, to] :
         {std::pair("POSITION", &mesh.positions), std::pair("NORMAL", &mesh.normals)}) {
      const std::optional<std::size_t> index = index_of(target, name);
      if (!index || to->empty()) continue;
      const std::string at = below(below(below(place_, "targets"), t), name);
      if (accessors_[*index].components != 3 || accessors_[*index].count * 3 != to->size()) {
        context_.error(at, concat("expected ", to->size() / 3, " elements of 3 components"));
        return false;
      }
      const Floats changes = accessors_.read(*index);
      if (!changes) return false;
      for (std::size_t i = 0; i < to->size(); ++i)
        (*to)[i] = static_cast<float>((*to)[i] + weights[t] * (*changes)[i]);
    }
  }
  return true;
}

bool PrimitiveReader::bend(const std::vector<Imath::M44d>& world_from_joint, wire::MeshData& mesh) {
  const std::size_t count = mesh.positions.size() / 3;
  std::vector<Imath::M44d> blends(count);
  for (Imath::M44d& blend : blends) blend = blend * 0.0;
  std::vector<double> sums(count, 0.0);
  for (int set = 0;; ++set) {
    const std::string joints_name = concat("JOINTS_", set), weights_name = concat("WEIGHTS_", set);
    const Floats joints = attribute(joints_name), weights = attribute(weights_name);
    if (joints.has_value() != weights.has_value())
      context_.error(below(place_, "attributes"), concat(joints_name, " and ", weights_name, " go together"));
    if (context_.diagnostics.has_errors()) return false;
    if (!joints) break;
    for (std::size_t i = 0; i < joints->size(); ++i) {
      const double weight = (*weights)[i];
      if (weight == 0) continue;
      const auto joint = static_cast<std::size_t>(std::max((*joints)[i], 0.0f));
      if (joint >= world_from_joint.size() || weight < 0) {
        context_.error(
            below(below(place_, "attributes"), joints_name),
            concat("joint ", joint, " with the weight ", weight, ", of ", world_from_joint.size()));
        return false;
      }
      blends[i / 4] += world_from_joint[joint] * weight;
      sums[i / 4] += weight;
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    // A vertex that no joint holds stays where it is.
    const Imath::M44d blend = sums[i] > 0 ? blends[i] * (1 / sums[i]) : Imath::M44d();
    const auto vector_at = [&](const std::vector<float>& from) {
      return Imath::V3d(from[3 * i], from[3 * i + 1], from[3 * i + 2]);
    };
    const Imath::V3d p = transformed_vector(vector_at(mesh.positions), blend);
    for (int c = 0; c < 3; ++c)
      mesh.positions[3 * i + static_cast<std::size_t>(c)] = static_cast<float>(p[c] + blend[3][c]);
    if (mesh.normals.empty()) continue;
    const std::optional<Imath::M44d> undone = inverse(blend);
    if (!undone) continue;
    const Imath::V3d n = transformed_vector(vector_at(mesh.normals), undone->transposed());
    for (int c = 0; c < 3; ++c) mesh.normals[3 * i + static_cast<std::size_t>(c)] = static_cast<float>(n[c]);
  }
  const bool sound = std::ranges::all_of(mesh.positions, [](float x) { return std::isfinite(x); });
  if (!sound) context_.error(place_, "its skin moves vertices to where no number reaches");
  return sound;
}

}  // namespace tessera::client::gltf
