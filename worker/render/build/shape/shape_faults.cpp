#include "render/build/shape/shape_faults.h"

#include "absl/strings/str_cat.h"
#include "render/build/placement/render_space.h"
#include "render/build/shape/csg.h"
#include "render/build/shape/csg_solid.h"
#include "render/build/shape/geometry.h"
#include "render/build/values/located.h"

namespace tessera::render {

namespace {

class FaultFinder {
 public:
  FaultFinder(const BlobSource& blobs, std::size_t most) : blobs_(blobs), most_(most) {}

  bool full() const { return faults.size() >= most_; }

  void look_at(const v1::Shape& shape, const Transform& space_from_holder, const std::string& place) {
    const auto holder_from_shape = Transform::from_proto(shape.world_from_object());
    if (!holder_from_shape.ok()) return add(shape, place, holder_from_shape.status());
    if (const auto end = Transform::from_proto(shape.world_from_object_end()); !end.ok())
      return add(shape, place, end.status());
    if (const char* const dark = kind_without_light(shape); dark != nullptr && shape.has_area_light())
      add(shape, place, absl::InvalidArgumentError(absl::StrCat(dark, " cannot emit light")));
    const Transform placed = space_from_holder * *holder_from_shape;
    if (shape.has_csg()) return look_at_combination(shape, placed, place);
    if (shape.has_mesh() || shape.has_curves()) return;
    ShapeTable unused;
    ShapeRecord record;
    add(shape, place, add_geometry(shape, placed, false, blobs_, unused, record));
  }

  std::vector<ShapeFault> faults;

 private:
  void add(const v1::Shape& shape, const std::string& place, const absl::Status& status) {
    if (!status.ok() && !full()) faults.push_back({&shape, place, std::string(status.message())});
  }

  void look_at_combination(const v1::Shape& shape, const Transform& placed, const std::string& place) {
    const auto tree = read_csg_tree(shape.csg());
    if (!tree.ok()) return add(shape, place, tree.status());
    const std::size_t before = faults.size();
    for (std::size_t i = 0; i < tree->solids.size(); ++i) {
      // The bounds of an implicit surface, which stand before it, are no shape of the scene.
      const std::int32_t operand = tree->solids[i].operand;
      const bool bounds = i + 1 < tree->solids.size() && tree->solids[i + 1].operand == operand;
      const v1::Shape& message = *tree->solids[bounds ? i + 1 : i].shape;
      const std::string where = absl::StrCat(place, ", ", place_in_scene("operand", operand, message.name()));
      const auto read = read_csg_operand(*tree->solids[i].shape, blobs_);
      add(message, where, read.status());
      if (!read.ok() || !message.has_mesh()) continue;
      add(message, where, closed_mesh_of(message.mesh(), read->combination_from_object, blobs_).status());
    }
    if (faults.size() > before) return;
    ShapeTable unused;
    ShapeRecord record;
    std::vector<ShapeRecord> solids;
    add(shape, place, add_csg(shape, *tree, placed, blobs_, unused, record, solids).status());
  }

  const BlobSource& blobs_;
  const std::size_t most_;
};

}  // namespace

std::vector<ShapeFault> find_shape_faults(const v1::Scene& scene, const BlobSource& blobs, std::size_t most) {
  // Faults of the camera are told elsewhere.
  const auto origin = render_origin(scene);
  const RenderSpace space = render_space_about(origin.ok() ? *origin : Imath::V3d(0, 0, 0));
  FaultFinder finder(blobs, most);
  for (int i = 0; i < scene.shapes_size() && !finder.full(); ++i)
    finder.look_at(scene.shapes(i), space.from_world, place_in_scene("shape", i, scene.shapes(i).name()));
  for (const v1::Object& object : scene.objects()) {
    for (int i = 0; i < object.shapes_size() && !finder.full(); ++i) {
      finder.look_at(object.shapes(i), Transform{},
                     absl::StrCat("object '", object.name(), "', ",
                                  place_in_scene("shape", i, object.shapes(i).name())));
    }
  }
  return std::move(finder.faults);
}

}  // namespace tessera::render
