#include "render/scene/shape/csg_tree.h"

#include "absl/strings/str_cat.h"
#include "wire/csg_limits.h"

namespace tessera::render {

namespace {

/// The box or ball that bounds an implicit surface.
v1::Shape bounds_of(const v1::Shape& shape) {
  v1::Shape bounds;
  bounds.set_material(shape.material());
  *bounds.mutable_world_from_object() = shape.world_from_object();
  const v1::ImplicitSurface& surface = shape.implicit();
  const auto rounded = [](double x) { return static_cast<float>(x); };
  if (surface.has_ball()) {
    bounds.mutable_sphere()->set_radius(rounded(surface.ball().radius()));
    if (bounds.world_from_object().elements().empty()) {
      for (int i = 0; i < 16; ++i) bounds.mutable_world_from_object()->add_elements(i % 5 == 0);
    }
    if (bounds.world_from_object().elements_size() != 16) return bounds;
    const v1::Point3& c = surface.ball().center();
    auto& m = *bounds.mutable_world_from_object()->mutable_elements();
    for (int row = 0; row < 12; row += 4)
      m[row + 3] += m[row] * rounded(c.x()) + m[row + 1] * rounded(c.y()) + m[row + 2] * rounded(c.z());
    return bounds;
  }
  const auto corner = [&](const v1::Point3& p, auto* numbers) {
    for (const double x : {p.x(), p.y(), p.z()}) numbers->Add(rounded(x));
  };
  corner(surface.box().low(), bounds.mutable_box()->mutable_low());
  corner(surface.box().high(), bounds.mutable_box()->mutable_high());
  return bounds;
}

}  // namespace

absl::StatusOr<CsgTree> read_csg_tree(const v1::Csg& csg) {
  CsgTree tree;
  std::vector<std::int32_t> open;
  const auto add = [&](CsgTree::Node node) {
    const auto index = static_cast<std::int32_t>(tree.nodes.size());
    if (!open.empty()) tree.nodes[static_cast<std::size_t>(open.back())].operands.push_back(index);
    tree.nodes.push_back(std::move(node));
    return index;
  };
  const auto begin = [&](v1::Csg::Operation operation, v1::Csg::CutFaces cut_faces) -> absl::Status {
    if (!v1::Csg::Operation_IsValid(operation) || !v1::Csg::CutFaces_IsValid(cut_faces))
      return absl::InvalidArgumentError("an operation, or its cut faces, is none that is known");
    if (open.size() >= wire::kMostCsgDepth)
      return absl::InvalidArgumentError(
          absl::StrCat("more than ", wire::kMostCsgDepth, " groups within one another"));
    open.push_back(add({operation, cut_faces == v1::Csg::CUT, -1, {}}));
    return absl::OkStatus();
  };
  const auto end = [&]() -> absl::Status {
    if (tree.nodes[static_cast<std::size_t>(open.back())].operands.empty())
      return absl::InvalidArgumentError("a group has no operands");
    open.pop_back();
    return absl::OkStatus();
  };
  std::int32_t operands = 0;
  const auto add_one = [&](const v1::Shape& shape) {
    add({v1::Csg::UNION, false, static_cast<std::int32_t>(tree.solids.size()), {}});
    tree.solids.push_back({&shape, operands});
  };
  const auto add_solid = [&](const v1::Shape& shape) {
    if (shape.has_implicit()) {
      // A solid that its bounds cut has their faces, which are named first.
      open.push_back(add({v1::Csg::INTERSECTION, false, -1, {}}));
      add_one(tree.bounds.emplace_back(bounds_of(shape)));
      add_one(shape);
      open.pop_back();
    } else {
      add_one(shape);
    }
    ++operands;
  };
  if (auto s = begin(csg.operation(), csg.cut_faces()); !s.ok()) return s;
  for (const v1::Csg::Part& part : csg.parts()) {
    absl::Status status;
    switch (part.kind_case()) {
      case v1::Csg::Part::kSolid:
        if (tree.solids.size() >= wire::kMostCsgSolids)
          return absl::InvalidArgumentError(absl::StrCat("more than ", wire::kMostCsgSolids, " solids"));
        add_solid(part.solid());
        break;
      case v1::Csg::Part::kBegin:
        // Groups without solids are refused in the end; here they must not fill the memory.
        if (tree.nodes.size() > std::size_t{4} * wire::kMostCsgSolids)
          return absl::InvalidArgumentError(
              absl::StrCat("more than ", 4 * wire::kMostCsgSolids, " groups and solids"));
        status = begin(part.begin().operation(), part.begin().cut_faces());
        break;
      case v1::Csg::Part::kEnd:
        status = open.size() > 1 ? end() : absl::InvalidArgumentError("an end without a beginning");
        break;
      case v1::Csg::Part::KIND_NOT_SET:
        status = absl::InvalidArgumentError("a part is neither a solid nor the begin or end of a group");
    }
    if (!status.ok()) return status;
  }
  if (open.size() > 1) return absl::InvalidArgumentError("a group has no end");
  if (auto s = end(); !s.ok()) return s;
  return tree;
}

}  // namespace tessera::render
