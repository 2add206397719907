// Mitsuba shapes -> Shape, Object and Instance messages.
#pragma once

#include <map>
#include <set>
#include <string>

#include "import/mitsuba/emitters.h"
#include "import/mitsuba/matter/materials.h"
#include "import/mitsuba/matter/media.h"
#include "import/mitsuba/shapes/meshes.h"

namespace tessera::client::mitsuba {

class ShapeWriter {
 public:
  ShapeWriter(Context& context, SceneTextures& textures, MaterialTable& materials, MediumTable& media)
      : context_(context), textures_(textures), materials_(materials), media_(media), meshes_(context) {}

  /// A shape that stands in the world. A "shapegroup" only counts once an "instance" names it.
  void write(Object& object);

  /// Reads the meshes of all shapes.
  void finish() { meshes_.load(); }

 private:
  /// In the world, or beyond Mitsuba in a "shapegroup".
  void write_instance(Object& object, google::protobuf::RepeatedPtrField<v1::Instance>& to);
  /// The name in the scene of a "shapegroup".
  std::string use_group(Object& group);
  /// False where there is nothing to add.
  bool write_shape(Object& object, bool in_group, v1::Shape& shape);
  bool write_geometry(PropertyReader& reader, v1::Shape& shape);
  bool write_geometry(PropertyReader& reader, const Imath::M44d& world_from_object, v1::Shape& shape);
  void write_sphere(PropertyReader& reader, Imath::M44d world_from_object, v1::Shape& shape);
  void write_cylinder(PropertyReader& reader, Imath::M44d world_from_object, v1::Shape& shape);
  void write_disk(const Imath::M44d& world_from_object, v1::Shape& shape);
  bool write_sdf_grid(PropertyReader& reader, v1::Shape& shape);

  Context& context_;
  SceneTextures& textures_;
  MaterialTable& materials_;
  MediumTable& media_;
  MeshTable meshes_;
  std::map<const Object*, std::string> groups_;
  std::set<std::string> group_names_;
  std::set<const Object*> open_groups_;  // groups whose shapes are being written
};

}  // namespace tessera::client::mitsuba
