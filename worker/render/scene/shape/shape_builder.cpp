#include "render/scene/shape/shape_builder.h"

#include "absl/strings/str_cat.h"
#include "render/scene/shape/csg.h"
#include "render/scene/shape/geometry.h"
#include "render/scene/values/located.h"

namespace tessera::render {

absl::Status ShapeBuilder::add(const v1::Shape& shape, const Transform& placed_from_object, bool instanced,
                               const std::string& where, std::span<const Transform> later_places) {
  ShapeRecord record;
  const auto material = inputs_.materials.find(shape.material());
  if (!material.ok()) return material.status();
  record.material = *material;
  if (auto s = set_media(shape, record); !s.ok()) return s;
  // A surface of nothing matters only as the border of a medium. Operands of a combination have materials of
  // their own.
  const BsdfKind kind = inputs_.material_table.materials[static_cast<std::size_t>(*material)].kind;
  if (kind == BsdfKind::kInterface && !shape.has_csg() && !shape.has_area_light() &&
      !(record.flags & kMediumBorder))
    return absl::OkStatus();

  if (auto s = set_alpha(shape, record); !s.ok()) return s;
  if (shape.has_csg()) return add_combination(shape, placed_from_object, where, record);
  // Lights that are flat are sampled as triangles and rectangles.
  const bool as_triangles = shape.has_area_light() || inputs_.triangles_only;
  if (auto s = add_geometry(shape, placed_from_object, as_triangles, inputs_.blobs, table_, record,
                            inputs_.stop, later_places);
      !s.ok())
    return s;
  const std::int32_t index = append(shape, where, record);
  if (auto s = add_attributes(shape, index); !s.ok()) return s;
  return shape.has_area_light() ? add_emitter(shape, instanced, where, index) : absl::OkStatus();
}

std::int32_t ShapeBuilder::append(const v1::Shape& shape, const std::string& where,
                                  const ShapeRecord& record) {
  table_.shapes.push_back(record);
  names_.push_back(where);
  messages_.push_back(&shape);
  return static_cast<std::int32_t>(table_.shapes.size()) - 1;
}

absl::Status ShapeBuilder::add_attributes(const v1::Shape& shape, std::int32_t index) {
  return shape.has_mesh() ? inputs_.attributes.add(shape.mesh(), table_, index) : absl::OkStatus();
}

absl::Status ShapeBuilder::add_combination(const v1::Shape& shape, const Transform& placed_from_object,
                                           const std::string& where, ShapeRecord& record) {
  if (shape.has_area_light())
    return absl::InvalidArgumentError(absl::StrCat(kind_without_light(shape), " cannot emit light"));
  const auto tree = read_csg_tree(shape.csg());
  if (!tree.ok()) return tree.status();
  Combination combination;
  const auto there =
      add_csg(shape, *tree, placed_from_object, inputs_.blobs, table_, record, combination.solids);
  if (!there.ok()) return there.status();
  if (!*there) {
    warnings_.push_back(absl::StrCat(where, ": its operands leave nothing; left out"));
    return absl::OkStatus();
  }
  if (is_crowded(table_.csgs.back())) {
    warnings_.push_back(absl::StrCat(
        where, ": ", kCrowd, " of its solids or more lie at one place: rays that go there take long"));
  }
  const auto passes = [&](std::int32_t material) {
    const MaterialRecord& m = inputs_.material_table.materials[static_cast<std::size_t>(material)];
    return (m.flags & (kHasOpacity | kPassesStraight)) != 0;
  };
  const std::int32_t own = record.material;
  for (std::size_t i = 0; i < tree->solids.size(); ++i) {
    ShapeRecord& solid = combination.solids[i];
    const v1::Shape& message = *tree->solids[i].shape;
    const std::string operand = place_in_scene("operand", tree->solids[i].operand, message.name());
    const auto material = inputs_.materials.find(message.material());
    if (!material.ok()) return located(material.status(), operand);
    solid.material = message.material().empty() ? own : *material;
    combination.names.push_back(absl::StrCat(where, ", ", operand));
    combination.meshes.push_back(message.has_mesh() ? &message : nullptr);
    solid.flags |= record.flags & kMediumBorder;
    solid.interior = record.interior, solid.exterior = record.exterior;
    // Light goes through a hit, if at all, by the material that it finds there; whether it may is asked of
    // the shape that was met.
    if (i == 0 || passes(solid.material)) record.material = solid.material;
  }
  combination.shape = append(shape, where, record);
  combinations_.push_back(std::move(combination));
  return absl::OkStatus();
}

absl::Status ShapeBuilder::add_solids_of_combinations() {
  for (const Combination& combination : combinations_) {
    const ShapeRecord whole = table_.shapes[static_cast<std::size_t>(combination.shape)];
    // Layers and the item buffer know the combination alone.
    const v1::Shape& whole_message = *messages_[static_cast<std::size_t>(combination.shape)];
    for (std::size_t i = 0; i < combination.solids.size(); ++i) {
      ShapeRecord record = combination.solids[i];
      record.number = whole.number;
      const std::int32_t index = append(whole_message, combination.names[i], record);
      table_.csgs[static_cast<std::size_t>(whole.quadric)].solids[i].shape = index;
      if (combination.meshes[i] == nullptr) continue;
      if (auto s = add_attributes(*combination.meshes[i], index); !s.ok())
        return located(s, combination.names[i]);
    }
  }
  return absl::OkStatus();
}

absl::Status ShapeBuilder::add_emitter(const v1::Shape& shape, bool instanced, const std::string& where,
                                       std::int32_t index) {
  if (const char* const dark = kind_without_light(shape); dark != nullptr)
    return absl::InvalidArgumentError(absl::StrCat(dark, " cannot emit light"));
  if (shape.has_curves()) {
    warnings_.push_back(absl::StrCat(where, ": curves cannot emit light; their area light is left out"));
  } else if (instanced) {
    waiting_[index] = {{index, &shape.area_light(), where}};
  } else {
    emitters_.push_back({index, &shape.area_light(), where});
  }
  return absl::OkStatus();
}

absl::StatusOr<std::int32_t> ShapeBuilder::place_emitter(std::int32_t shape) {
  Waiting& waiting = waiting_.at(shape);
  std::int32_t index = shape;
  if (waiting.placed) {
    // Its geometry is that of the first one.
    const auto at = static_cast<std::size_t>(shape);
    const ShapeRecord record = table_.shapes[at];
    const std::string where = names_[at];
    index = append(*messages_[at], where, record);
    if (auto s = add_attributes(*messages_[at], index); !s.ok()) return s;
  }
  waiting.placed = true;
  emitters_.push_back({index, waiting.emitter.light, waiting.emitter.where});
  return index;
}

absl::Status ShapeBuilder::set_media(const v1::Shape& shape, ShapeRecord& record) const {
  const auto interior = inputs_.media.find(shape.interior_medium()),
             exterior = inputs_.media.find(shape.exterior_medium());
  if (!interior.ok()) return interior.status();
  if (!exterior.ok()) return exterior.status();
  if (*interior == *exterior) return absl::OkStatus();
  record.flags |= kMediumBorder;
  record.interior = *interior, record.exterior = *exterior;
  return absl::OkStatus();
}

absl::Status ShapeBuilder::set_alpha(const v1::Shape& shape, ShapeRecord& record) {
  if (!shape.has_alpha()) return absl::OkStatus();
  if (shape.alpha().has_texture()) {
    auto node = inputs_.textures.exact_node(shape.alpha().texture());
    if (!node.ok()) return node.status();
    record.alpha_texture = *node;
    record.flags |= kHasAlpha;
  } else if (shape.alpha().has_constant() && shape.alpha().constant() < 1) {
    record.alpha = shape.alpha().constant();
    record.flags |= kHasAlpha;
  }
  return absl::OkStatus();
}

}  // namespace tessera::render
