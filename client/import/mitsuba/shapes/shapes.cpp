#include "import/mitsuba/shapes/shapes.h"

#include <cmath>
#include <initializer_list>

#include "import/geometry/vertex_normals.h"
#include "import/input/concat.h"
#include "import/input/input_file.h"
#include "import/mitsuba/matter/volume_file.h"
#include "import/mitsuba/shapes/basic_meshes.h"

namespace tessera::client::mitsuba {
namespace {

void write_uv_transform(std::initializer_list<float> elements, v1::Shape& shape) {
  for (const float element : elements) shape.add_uv_transform(element);
}

/// A rotation that takes +z to `axis`, a unit vector [Duff et al. 2017].
Imath::M44d frame_about(const Imath::V3d& axis) {
  const double sign = std::copysign(1.0, axis[2]);
  const double a = -1 / (sign + axis[2]), b = axis[0] * axis[1] * a;
  const Imath::V3d s = {1 + sign * axis[0] * axis[0] * a, sign * b, -sign * axis[0]};
  const Imath::V3d t = {b, sign + axis[1] * axis[1] * a, -axis[1]};
  Imath::M44d frame;
  for (int r = 0; r < 3; ++r) {
    frame[0][r] = s[r];
    frame[1][r] = t[r];
    frame[2][r] = axis[r];
  }
  return frame;
}

}  // namespace

void ShapeWriter::write(Object& object) {
  if (object.type == "shapegroup") return;
  if (object.type == "instance") return write_instance(object, *context_.scene.mutable_instances());
  v1::Shape& shape = *context_.scene.add_shapes();
  if (!write_shape(object, false, shape)) context_.scene.mutable_shapes()->RemoveLast();
}

void ShapeWriter::write_instance(Object& object, google::protobuf::RepeatedPtrField<v1::Instance>& to) {
  PropertyReader reader(context_, object);
  Object* group = reader.child("shape");
  if (group == nullptr || group->type != "shapegroup") {
    reader.error("shape \"instance\": expected a shapegroup inside");
    return;
  }
  // Each may hold the next; the renderer's bound is the same (scene/shape/object_graph.h).
  constexpr std::size_t kDeepest = 64;
  if (open_groups_.contains(group) || open_groups_.size() == kDeepest) {
    reader.error(open_groups_.contains(group)
                     ? concat(group->title(), " holds itself")
                     : concat("shapegroups within shapegroups: more than ", kDeepest, " deep"));
    return;
  }
  const std::string name = use_group(*group);
  v1::Instance& instance = *to.Add();
  instance.set_object(name);
  const std::vector<TimedPlacing> motion = reader.motion("to_world");
  const Imath::M44d& world_from_instance = motion.front().place;
  if (!inverse(world_from_instance)) reader.error("shape \"instance\": its transformation is singular");
  write_matrix(world_from_instance, *instance.mutable_world_from_instance());
  write_motion(motion, instance);
}

std::string ShapeWriter::use_group(Object& group) {
  const auto known = groups_.find(&group);
  if (known != groups_.end()) return known->second;
  const std::string name = Context::unique_name(group, "shapegroup", group_names_);
  groups_[&group] = name;
  PropertyReader reader(context_, group);
  v1::Object& message = *context_.scene.add_objects();
  message.set_name(name);
  open_groups_.insert(&group);
  for (const Property* property : reader.children("shape")) {
    Object& child = *std::get<Object*>(property->value);
    if (child.type == "instance") {
      write_instance(child, *message.mutable_instances());
    } else if (child.type == "shapegroup") {
      context_.diagnostics.error(property->where,
                                 concat("a ", child.title(), " cannot stand inside a shapegroup"));
    } else if (!write_shape(child, true, *message.add_shapes())) {
      message.mutable_shapes()->RemoveLast();
    }
  }
  open_groups_.erase(&group);
  if (reader.has("to_world"))
    reader.warn("the transformation of a shapegroup is left out: its instances have theirs");
  reader.ignore({"to_world"});
  return name;
}

bool ShapeWriter::write_shape(Object& object, bool in_group, v1::Shape& shape) {
  PropertyReader reader(context_, object);
  shape.set_name(context_.name_with_place(object));
  shape.set_group(object.id);
  // Media first: a mesh may have to swap them.
  if (Object* medium = reader.named_child("interior", "medium"))
    shape.set_interior_medium(media_.use(*medium));
  if (Object* medium = reader.named_child("exterior", "medium"))
    shape.set_exterior_medium(media_.use(*medium));
  if (reader.boolean("flip_normals", false)) shape.set_reverse_orientation(true);
  if (!write_geometry(reader, shape)) return false;

  Object* emitter = reader.child("emitter");
  if (emitter != nullptr && in_group) {
    reader.error(concat(reader.object().title(), ": shapes of a shapegroup cannot emit light"));
  } else if (emitter != nullptr) {
    const std::string& type = object.type;
    const bool may_have_normals = type == "obj" || type == "ply" || type == "serialized";
    write_area_light(context_, textures_, *emitter, may_have_normals, shape);
  }
  Object* bsdf = reader.child("bsdf");
  shape.set_material(bsdf != nullptr ? materials_.use(*bsdf) : materials_.use_default(emitter != nullptr));
  if (reader.child("sensor") != nullptr) reader.warn("a sensor on a shape is left out");
  // Steers gradients only.
  reader.ignore({"silhouette_sampling_weight"});
  return true;
}

bool ShapeWriter::write_geometry(PropertyReader& reader, v1::Shape& shape) {
  std::vector<TimedPlacing> motion = reader.motion("to_world");
  const Imath::M44d to_world = motion.front().place;
  if (!write_geometry(reader, to_world, shape)) return false;
  const std::optional<Imath::M44d> back = inverse(to_world);
  if (!back || motion.size() == 1) return true;
  // Spheres and cylinders have a place of their own within.
  const Imath::M44d own = matrix_of(shape.world_from_object()) * *back;
  for (TimedPlacing& placing : motion) placing.place = own * placing.place;
  write_motion(motion, shape);
  return true;
}

bool ShapeWriter::write_geometry(PropertyReader& reader, const Imath::M44d& world_from_object,
                                 v1::Shape& shape) {
  const std::string& type = reader.object().type;
  if (!inverse(world_from_object))
    reader.error(concat(reader.object().title(), ": its transformation is singular"));
  write_matrix(world_from_object, *shape.mutable_world_from_object());
  if (type == "obj" || type == "ply" || type == "serialized") {
    meshes_.add_file(reader, world_from_object, shape);
  } else if (type == "rectangle") {
    meshes_.add(rectangle_mesh(), shape);
  } else if (type == "cube") {
    reader.ignore({"face_normals"});
    meshes_.add(cube_mesh(), shape);
  } else if (type == "sphere") {
    write_sphere(reader, world_from_object, shape);
  } else if (type == "cylinder") {
    write_cylinder(reader, world_from_object, shape);
  } else if (type == "disk") {
    write_disk(world_from_object, shape);
  } else if (type == "sdfgrid") {
    return write_sdf_grid(reader, shape);
  } else {
    reader.error(
        concat("shape \"", type,
               "\" is not supported: expected obj, ply, serialized, rectangle, cube, sphere, cylinder, disk, "
               "sdfgrid, shapegroup or instance"));
    return false;
  }
  return true;
}

void ShapeWriter::write_sphere(PropertyReader& reader, Imath::M44d world_from_object, v1::Shape& shape) {
  const Imath::V3d center = reader.vector("center").value_or(Imath::V3d{0, 0, 0});
  const double radius = reader.number("radius", 1);
  if (!(radius > 0)) reader.error("shape \"sphere\": its radius is not above 0");
  world_from_object = translation(center[0], center[1], center[2]) * world_from_object;
  if (!keeps_angles(world_from_object)) {
    reader.warn("a sphere that is stretched becomes an ellipsoid; in Mitsuba it stays a sphere");
  }
  // A mirrored sphere is a sphere, but its normals point inwards, in Mitsuba as here.
  write_matrix(world_from_object, *shape.mutable_world_from_object());
  shape.mutable_sphere()->set_radius(static_cast<float>(radius));
  // v grows from the pole at +z.
  write_uv_transform({1, 0, 0, 0, -1, 1}, shape);
}

void ShapeWriter::write_cylinder(PropertyReader& reader, Imath::M44d world_from_object, v1::Shape& shape) {
  const Imath::V3d p0 = reader.vector("p0").value_or(Imath::V3d{0, 0, 0}),
                   p1 = reader.vector("p1").value_or(Imath::V3d{0, 0, 1});
  const double radius = reader.number("radius", 1);
  const Imath::V3d axis = p1 - p0;
  const double length = std::hypot(axis[0], axis[1], axis[2]);
  if (!(radius > 0) || !(length > 0)) {
    reader.error("shape \"cylinder\": its radius and its length must be above 0");
    return;
  }
  world_from_object = frame_about(axis / length) * (translation(p0[0], p0[1], p0[2]) * world_from_object);
  write_matrix(world_from_object, *shape.mutable_world_from_object());
  v1::Cylinder& cylinder = *shape.mutable_cylinder();
  cylinder.set_radius(static_cast<float>(radius));
  cylinder.set_z_max(static_cast<float>(length));
}

void ShapeWriter::write_disk(const Imath::M44d& world_from_object, v1::Shape& shape) {
  shape.mutable_disk()->set_radius(1);
  // In Mitsuba a mirrored disk keeps its normal, transformed as normals are.
  if (determinant3(world_from_object) < 0) shape.set_reverse_orientation(!shape.reverse_orientation());
  // u is the distance from the centre, v the angle.
  write_uv_transform({0, -1, 1, 1, 0, 0}, shape);
}

bool ShapeWriter::write_sdf_grid(PropertyReader& reader, v1::Shape& shape) {
  const std::string normals = reader.keyword("normals", "smooth");
  if (normals != "smooth" && normals != "analytic") {
    reader.error(*reader.find("normals"), concat("expected smooth or analytic, found \"", normals, "\""));
  }
  const std::optional<std::filesystem::path> path = reader.file("filename");
  if (!path) return false;
  absl::StatusOr<InputFile> input = InputFile::open(*path);
  absl::StatusOr<VolumeFile> file = input.ok() ? read_volume_file(input->bytes()) : input.status();
  if (!file.ok()) {
    reader.error(*reader.find("filename"),
                 concat(path->string(), ": ", std::string(file.status().message())));
    return false;
  }
  for (const std::uint32_t side : file->size) {
    if (side >= 2 && file->channels == 1) continue;
    reader.error(*reader.find("filename"),
                 "a signed distance needs one channel and two samples along each axis");
    return false;
  }
  v1::SdfGrid& grid = *shape.mutable_sdf_grid();
  *grid.mutable_blob() = context_.blobs.add_bytes(std::move(file->blob));
  grid.mutable_blob()->set_path(reader.text("filename", ""));
  grid.set_smooth_normals(normals == "smooth");
  reader.ignore({"watertight"});
  return true;
}

}  // namespace tessera::client::mitsuba
