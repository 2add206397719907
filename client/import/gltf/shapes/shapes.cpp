#include "import/gltf/shapes/shapes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "import/gltf/shapes/primitives.h"

namespace tessera::client::gltf {
namespace {

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

std::string bytes_of(const std::vector<float>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)};
}

/// A primitive as a shape without a place.
struct Part {
  v1::Shape shape;
  Imath::V3d low, high;  // bounds of its vertices
};

class ShapeWriter {
 public:
  ShapeWriter(Context& context, BufferTable& buffers, AccessorTable& accessors, MaterialTable& materials,
              const std::vector<Node>& nodes)
      : context_(context),
        accessors_(accessors),
        materials_(materials),
        nodes_(nodes),
        reader_(context, buffers, accessors) {}

  Extent write() {
    std::map<std::size_t, std::size_t> uses_by_mesh;
    for (const Node& node : nodes_) {
      if (const auto mesh = shown_mesh(node))
        uses_by_mesh[*mesh] += is_deformed(node, *mesh) ? 0 : count_of(node);
    }
    for (const Node& node : nodes_) {
      if (context_.diagnostics.full()) break;
      if (const auto mesh = shown_mesh(node)) write_node(node, *mesh, uses_by_mesh[*mesh] > 1);
    }
    check_unused();
    return extent_;
  }

 private:
  std::optional<std::size_t> shown_mesh(const Node& node) const {
    return node.is_in_scene ? index_of(node.json, "mesh") : std::nullopt;
  }
  const Json& mesh_json(std::size_t mesh) const { return *element(&context_.document, "meshes", mesh); }
  /// Those of a pose, or else of the mesh.
  std::vector<double> weights_of(const std::vector<double>& of_pose, std::size_t mesh) const {
    if (!of_pose.empty()) return of_pose;
    std::vector<double> weights;
    for (std::size_t i = 0; i < size_of(&mesh_json(mesh), "weights"); ++i)
      weights.push_back(element(&mesh_json(mesh), "weights", i)->get<double>());
    return weights;
  }
  bool is_deformed(const Node& node, std::size_t mesh) const {
    return index_of(node.json, "skin").has_value() ||
           (size_of(element(&mesh_json(mesh), "primitives", 0), "targets") > 0 &&
            !weights_of(node.pose.weights, mesh).empty());
  }
  std::size_t count_of(const Node& node) const {
    const Json* attributes = member(extension(node.json, kInstancing), "attributes");
    if (attributes == nullptr || attributes->empty()) return 1;
    return accessors_[static_cast<std::size_t>(attributes->begin()->get<double>())].count;
  }

  /// The material that the chosen variant gives a primitive.
  std::optional<std::size_t> material_of(const Json& primitive) const {
    const Json* mappings = extension(&primitive, "KHR_materials_variants");
    if (mappings == nullptr || context_.options.variant.empty()) return index_of(&primitive, "material");
    for (std::size_t i = 0; i < size_of(mappings, "mappings"); ++i) {
      const Json* mapping = element(mappings, "mappings", i);
      for (const Json& variant : *member(mapping, "variants")) {
        if (static_cast<std::size_t>(variant.get<double>()) == variant_) return index_of(mapping, "material");
      }
    }
    return index_of(&primitive, "material");
  }

  /// `later`: deformations while the shutter is open.
  std::vector<Part> read_mesh(std::size_t mesh, const Deformation& deformation,
                              const std::vector<Deformation>& later = {}) {
    std::vector<Part> parts;
    const Json& json = mesh_json(mesh);
    for (std::size_t p = 0; p < size_of(&json, "primitives") && !context_.diagnostics.full(); ++p) {
      const Json& primitive = *element(&json, "primitives", p);
      const std::string place = below(below(below("/meshes", mesh), "primitives"), p);
      const std::optional<std::size_t> material = material_of(primitive);
      const std::optional<Primitive> read =
          reader_.read(primitive, place, materials_.texture_set(material), deformation);
      if (!read || context_.diagnostics.has_errors()) continue;
      parts.push_back(make_part(*read, materials_.use(material, read->vertices())));
      for (const Deformation& next : later) {
        const std::optional<Primitive> key =
            reader_.read(primitive, place, materials_.texture_set(material), next);
        if (!key || context_.diagnostics.has_errors()) break;
        add_key(*key, parts.back());
      }
    }
    return parts;
  }

  Part make_part(const Primitive& primitive, const Matter& matter) {
    Part part;
    v1::TriangleMesh& mesh = *part.shape.mutable_mesh();
    *mesh.mutable_blob() = context_.blobs.add_bytes(wire::encode_mesh(primitive.mesh));
    const auto add_attribute = [&](const char* name, const std::vector<float>& values,
                                   std::uint32_t channels) {
      if (values.empty()) return;
      v1::MeshAttribute& attribute = *mesh.add_attributes();
      attribute.set_name(name);
      attribute.set_channels(channels);
      *attribute.mutable_blob() = context_.blobs.add_bytes(bytes_of(values));
    };
    add_attribute(kColorAttribute, primitive.colors, 3);
    add_attribute(kAlphaAttribute, primitive.alphas, 1);
    part.shape.set_material(matter.material);
    if (!matter.medium.empty()) part.shape.set_interior_medium(matter.medium);
    if (matter.emission) *part.shape.mutable_area_light() = *matter.emission;
    Extent box;
    const std::vector<float>& p = primitive.mesh.positions;
    for (std::size_t i = 0; i + 2 < p.size(); i += 3) box.add({p[i], p[i + 1], p[i + 2]});
    part.low = box.low, part.high = box.high;
    return part;
  }

  void add_key(const Primitive& primitive, Part& part) {
    *part.shape.mutable_mesh()->add_later_blobs() =
        context_.blobs.add_bytes(wire::encode_mesh(primitive.mesh));
    Extent box;
    box.add(part.low), box.add(part.high);
    const std::vector<float>& p = primitive.mesh.positions;
    for (std::size_t i = 0; i + 2 < p.size(); i += 3) box.add({p[i], p[i + 1], p[i + 2]});
    part.low = box.low, part.high = box.high;
  }

  const std::vector<Part>& parts_of(std::size_t mesh) {
    const auto [known, is_new] = parts_.try_emplace(mesh);
    if (is_new) known->second = read_mesh(mesh, {});
    return known->second;
  }

  void write_node(const Node& node, std::size_t mesh, bool is_shared) {
    if (is_deformed(node, mesh)) {
      Deformation deformation;
      std::vector<Deformation> later(node.later.size());
      deformation.weights = weights_of(node.pose.weights, mesh);
      for (std::size_t k = 0; k < later.size(); ++k)
        later[k].weights = weights_of(node.later[k].weights, mesh);
      const auto skin = index_of(node.json, "skin");
      if (skin && !read_skin(*skin, deformation, later)) return;
      if (std::ranges::all_of(later, [&](const Deformation& next) { return next == deformation; }))
        later.clear();
      place(read_mesh(mesh, deformation, later), node, skin ? Imath::M44d() : node.world_from_node);
      return;
    }
    const std::vector<Part>& parts = parts_of(mesh);
    for (const Imath::M44d& world_from_mesh : placings_of(node)) {
      if (is_shared) {
        place_object(mesh, parts, node, world_from_mesh);
      } else {
        place(parts, node, world_from_mesh);
      }
    }
  }

  std::vector<Imath::M44d> placings_of(const Node& node) {
    const Json* attributes = member(extension(node.json, kInstancing), "attributes");
    if (attributes == nullptr || attributes->empty()) return {node.world_from_node};
    const std::string place = below(below(below(node.place, "extensions"), kInstancing), "attributes");
    const std::size_t count = count_of(node);
    const auto read = [&](const char* name, int components) -> std::vector<float> {
      const auto index = index_of(attributes, name);
      if (!index) return {};
      if (accessors_[*index].components != components || accessors_[*index].count != count) {
        context_.error(below(place, name),
                       concat("expected ", count, " elements of ", components, " components"));
        return {};
      }
      return accessors_.read(*index).value_or(std::vector<float>());
    };
    constexpr std::uint64_t kCostOfInstance = 16;
    if (!context_.spend(kCostOfInstance * count, place)) return {};
    const std::vector<float> t = read("TRANSLATION", 3), r = read("ROTATION", 4), s = read("SCALE", 3);
    std::vector<Imath::M44d> result;
    if (context_.diagnostics.has_errors()) return result;
    const auto at = [](const std::vector<float>& values, std::size_t i, double otherwise) {
      return values.empty() ? Imath::V3d(otherwise)
                            : Imath::V3d(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
    };
    for (std::size_t i = 0; i < count; ++i) {
      double rotation[4] = {0, 0, 0, 1};
      for (std::size_t c = 0; c < 4 && !r.empty(); ++c) rotation[c] = r[4 * i + c];
      result.push_back(placing(at(t, i, 0), rotation, at(s, i, 1)) * node.world_from_node);
    }
    return result;
  }

  bool read_skin(std::size_t skin, Deformation& deformation, std::vector<Deformation>& later) {
    const Json& json = *element(&context_.document, "skins", skin);
    const std::string place = below("/skins", skin);
    const auto matrices = index_of(&json, "inverseBindMatrices");
    const std::size_t joints = size_of(&json, "joints");
    if (!context_.spend(joints, place)) return false;
    std::optional<std::vector<float>> inverse_bind;
    if (matrices) {
      inverse_bind = accessors_.read(*matrices);
      if (!inverse_bind) return false;
    }
    for (std::size_t j = 0; j < joints; ++j) {
      const auto node = static_cast<std::size_t>(element(&json, "joints", j)->get<double>());
      Imath::M44d joint_from_mesh;
      for (std::size_t i = 0; i < 16 && inverse_bind; ++i)
        joint_from_mesh[static_cast<int>(i / 4)][i % 4] = (*inverse_bind)[16 * j + i];
      deformation.world_from_joint.push_back(joint_from_mesh * nodes_[node].world_from_node);
      for (std::size_t k = 0; k < later.size(); ++k) {
        const std::vector<LaterPose>& poses = nodes_[node].later;
        later[k].world_from_joint.push_back(
            joint_from_mesh * (poses.empty() ? nodes_[node].world_from_node : poses[k].world_from_node));
      }
    }
    return true;
  }

  bool is_placeable(const Node& node, const Imath::M44d& world_from_mesh) {
    if (is_finite(world_from_mesh) && inverse(world_from_mesh)) return true;
    context_.warn(node.place, "what is flattened by its scale is left out");
    return false;
  }

  /// The motion of what a node has at that place when the shutter opens. Joints move skins, not the node.
  std::vector<TimedPlacing> motion_of(const Node& node, const Imath::M44d& world_from_mesh) {
    std::vector<TimedPlacing> motion = node.motion;
    if (index_of(node.json, "skin")) motion.clear();
    if (motion.size() < 2) return motion;
    if (!(world_from_mesh == node.world_from_node)) {
      const Imath::M44d node_from_mesh =
          world_from_mesh * inverse(node.world_from_node).value_or(Imath::M44d());
      for (TimedPlacing& placing : motion) placing.place = node_from_mesh * placing.place;
    }
    const bool mirrors = determinant3(motion.front().place) < 0;
    const bool may_move = std::ranges::all_of(motion, [&](const TimedPlacing& placing) {
      return is_decomposable(placing.place) && (determinant3(placing.place) < 0) == mirrors;
    });
    if (may_move) return motion;
    context_.warn(
        node.place,
        "while the shutter is open, its scale is 0 or changes its sign: it stays where it is when the "
        "shutter opens");
    return {};
  }

  void place(const std::vector<Part>& parts, const Node& node, const Imath::M44d& world_from_mesh) {
    if (parts.empty() || !is_placeable(node, world_from_mesh)) return;
    for (const Part& part : parts) place(part, node, world_from_mesh);
  }

  void place(const Part& part, const Node& node, const Imath::M44d& world_from_mesh) {
    v1::Shape& shape = *context_.scene.add_shapes() = part.shape;
    write_matrix(world_from_mesh, *shape.mutable_world_from_object());
    write_motion(motion_of(node, world_from_mesh), shape);
    shape.set_name(node.name);
    extend(part, world_from_mesh);
  }

  void place_object(std::size_t mesh, const std::vector<Part>& parts, const Node& node,
                    const Imath::M44d& world_from_mesh) {
    if (parts.empty() || !is_placeable(node, world_from_mesh)) return;
    const std::string name = object_of(mesh, parts);
    if (!name.empty()) {
      v1::Instance& instance = *context_.scene.add_instances();
      instance.set_object(name);
      write_matrix(world_from_mesh, *instance.mutable_world_from_instance());
      write_motion(motion_of(node, world_from_mesh), instance);
    }
    for (const Part& part : parts) {
      // Shapes of objects emit nothing.
      if (part.shape.has_area_light()) {
        place(part, node, world_from_mesh);
      } else {
        extend(part, world_from_mesh);
      }
    }
  }

  /// The object of all parts that do not emit; empty where there are none.
  std::string object_of(std::size_t mesh, const std::vector<Part>& parts) {
    const auto [known, is_new] = objects_.try_emplace(mesh);
    if (!is_new) return known->second;
    v1::Object object;
    for (const Part& part : parts) {
      if (!part.shape.has_area_light()) *object.add_shapes() = part.shape;
    }
    if (object.shapes().empty()) return "";
    const std::string stem = text_of(&mesh_json(mesh), "name", "mesh");
    object.set_name(concat(stem, "-", mesh));
    known->second = object.name();
    *context_.scene.add_objects() = std::move(object);
    return known->second;
  }

  void extend(const Part& part, const Imath::M44d& world_from_mesh) {
    for (int i = 0; i < 8; ++i) {
      const Imath::V3d corner(i & 1 ? part.high.x : part.low.x, i & 2 ? part.high.y : part.low.y,
                              i & 4 ? part.high.z : part.low.z);
      const Imath::V3d p = transformed_vector(corner, world_from_mesh);
      extent_.add({p.x + world_from_mesh[3][0], p.y + world_from_mesh[3][1], p.z + world_from_mesh[3][2]});
    }
  }

  /// Reads meshes that no node shows, too, for what is wrong with them.
  void check_unused() {
    std::set<std::size_t> shown;
    for (const Node& node : nodes_) {
      if (const auto mesh = shown_mesh(node)) shown.insert(*mesh);
    }
    for (std::size_t m = 0; m < size_of(&context_.document, "meshes"); ++m) {
      const Json& json = mesh_json(m);
      for (std::size_t p = 0; p < size_of(&json, "primitives") && !context_.diagnostics.full(); ++p) {
        if (!shown.contains(m))
          reader_.read(*element(&json, "primitives", p), below(below(below("/meshes", m), "primitives"), p),
                       0, {});
      }
    }
  }

  Context& context_;
  AccessorTable& accessors_;
  MaterialTable& materials_;
  const std::vector<Node>& nodes_;
  PrimitiveReader reader_;
  std::size_t variant_ = find_variant();
  std::map<std::size_t, std::vector<Part>> parts_;
  std::map<std::size_t, std::string> objects_;
  Extent extent_;

  std::size_t find_variant() {
    const std::string& wanted = context_.options.variant;
    if (wanted.empty()) return 0;
    const Json* all = extension(&context_.document, "KHR_materials_variants");
    for (std::size_t i = 0; i < size_of(all, "variants"); ++i) {
      if (text_of(element(all, "variants", i), "name") == wanted || concat(i) == wanted) return i;
    }
    context_.error("/extensions/KHR_materials_variants", concat("there is no variant \"", wanted, "\""));
    return 0;
  }
};

}  // namespace

void Extent::add(const Imath::V3d& p) {
  for (int a = 0; a < 3; ++a) {
    low[a] = is_empty ? p[a] : std::min(low[a], p[a]);
    high[a] = is_empty ? p[a] : std::max(high[a], p[a]);
  }
  is_empty = false;
}

Extent write_shapes(Context& context, BufferTable& buffers, AccessorTable& accessors,
                    MaterialTable& materials, const std::vector<Node>& nodes) {
  return ShapeWriter(context, buffers, accessors, materials, nodes).write();
}

}  // namespace tessera::client::gltf
