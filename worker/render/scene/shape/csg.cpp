#include "render/scene/shape/csg.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "absl/strings/str_cat.h"
#include "render/scene/shape/csg_solid.h"
#include "render/scene/shape/geometry.h"
#include "render/scene/values/located.h"

namespace tessera::render {

namespace {

CsgBox meet(const CsgBox& a, const CsgBox& b) {
  CsgBox box;
  for (int i = 0; i < 3; ++i)
    box.low[i] = std::max(a.low[i], b.low[i]), box.high[i] = std::min(a.high[i], b.high[i]);
  return box;
}

CsgBox hull(const CsgBox& a, const CsgBox& b) {
  if (a.is_empty() || b.is_empty()) return a.is_empty() ? b : a;
  CsgBox box;
  for (int i = 0; i < 3; ++i)
    box.low[i] = std::min(a.low[i], b.low[i]), box.high[i] = std::max(a.high[i], b.high[i]);
  return box;
}

CsgBox empty_box() { return {Imath::V3d(1, 1, 1), Imath::V3d(-1, -1, -1)}; }

/// A box about what each node of the tree can be; operands stand behind their groups.
std::vector<CsgBox> boxes_of(const CsgTree& tree, const std::vector<CsgOperand>& operands) {
  std::vector<CsgBox> boxes(tree.nodes.size());
  for (std::size_t i = tree.nodes.size(); i-- > 0;) {
    const CsgTree::Node& node = tree.nodes[i];
    if (node.solid >= 0) {
      boxes[i] = operands[static_cast<std::size_t>(node.solid)].box;
      continue;
    }
    if (node.operation == v1::Csg::UNION) boxes[i] = empty_box();
    for (const std::int32_t operand : node.operands) {
      const CsgBox& box = boxes[static_cast<std::size_t>(operand)];
      if (node.operation == v1::Csg::UNION) {
        boxes[i] = hull(boxes[i], box);
      } else {
        boxes[i] = meet(boxes[i], box);
      }
      if (node.operation == v1::Csg::DIFFERENCE) break;
    }
  }
  return boxes;
}

/// Writes a tree's nodes for the kernels, in unit space: without what cannot matter within the box of the
/// whole, and with unions of many operands as trees of unions of neighbours.
class NodeWriter {
 public:
  NodeWriter(const CsgTree& tree, const std::vector<CsgBox>& boxes, const Imath::V3d& centre, double size,
             CsgRecord& csg)
      : tree_(tree), twins_(twins_of(tree)), boxes_(boxes), centre_(centre), size_(size), csg_(csg) {}

  void write(std::int32_t index, std::int32_t parent, std::int32_t weight, const CsgBox& parents,
             bool turned) {
    const CsgTree::Node& node = tree_.nodes[static_cast<std::size_t>(index)];
    const CsgBox box = meet(boxes_[static_cast<std::size_t>(index)], parents);
    if (box.is_empty()) return;
    const std::int32_t place = open(parent, weight, box);
    if (node.solid >= 0) {
      csg_.nodes.back().solid = node.solid;
      CsgSolid& solid = csg_.solids[static_cast<std::size_t>(node.solid)];
      solid.node = place, solid.turned = turned;
    } else if (node.operation == v1::Csg::UNION) {
      write_union(without_twins(node.operands), place, box, turned);
    } else if (node.operation == v1::Csg::INTERSECTION) {
      csg_.nodes.back().threshold = static_cast<std::int32_t>(node.operands.size());
      for (const std::int32_t operand : node.operands) write(operand, place, 1, box, turned);
    } else {
      csg_.nodes.back().keeps_material = node.keeps_material;
      write(node.operands.front(), place, 1, box, turned);
      const std::vector<std::int32_t> taken = without_twins({node.operands.begin() + 1, node.operands.end()});
      if (taken.size() == 1) {
        write(taken.front(), place, -1, box, !turned);
      } else if (!taken.empty()) {
        const std::int32_t all = open(place, -1, box);
        write_union(taken, all, box, !turned);
        close(all);
      }
    }
    close(place);
  }

 private:
  /// For each solid the first one that is the same but for its name and its material.
  static std::vector<std::int32_t> twins_of(const CsgTree& tree) {
    std::unordered_map<std::string, std::int32_t> known;
    std::vector<std::int32_t> twins;
    for (std::size_t i = 0; i < tree.solids.size(); ++i) {
      v1::Shape shape = *tree.solids[i].shape;
      shape.clear_name(), shape.clear_material();
      twins.push_back(
          known.try_emplace(shape.SerializeAsString(), static_cast<std::int32_t>(i)).first->second);
    }
    return twins;
  }

  /// Operands of a union without solids that are there before: all that is seen of those is seen of the
  /// first.
  std::vector<std::int32_t> without_twins(std::vector<std::int32_t> operands) const {
    std::unordered_set<std::int32_t> seen;
    std::erase_if(operands, [&](std::int32_t operand) {
      const std::int32_t solid = tree_.nodes[static_cast<std::size_t>(operand)].solid;
      return solid >= 0 && !seen.insert(twins_[static_cast<std::size_t>(solid)]).second;
    });
    return operands;
  }

  std::int32_t open(std::int32_t parent, std::int32_t weight, const CsgBox& box) {
    const auto place = static_cast<std::int32_t>(csg_.nodes.size());
    CsgNode& node = csg_.nodes.emplace_back();
    node.parent = parent, node.weight = weight;
    // Room for the roundings of the test.
    constexpr double kRoom = 1e-5;
    for (int a = 0; a < 3; ++a) {
      node.low[a] = static_cast<float>((box.low[a] - centre_[a]) / size_ - kRoom);
      node.high[a] = static_cast<float>((box.high[a] - centre_[a]) / size_ + kRoom);
    }
    return place;
  }
  void close(std::int32_t place) {
    csg_.nodes[static_cast<std::size_t>(place)].end = static_cast<std::int32_t>(csg_.nodes.size());
  }

  /// Operands of the union at `place`; many are halved by their middles along the longest axis.
  void write_union(std::vector<std::int32_t> operands, std::int32_t place, const CsgBox& box, bool turned) {
    const auto within = [&](std::int32_t operand) {
      return meet(boxes_[static_cast<std::size_t>(operand)], box);
    };
    std::erase_if(operands, [&](std::int32_t operand) { return within(operand).is_empty(); });
    constexpr std::size_t kFew = 4;
    if (operands.size() <= kFew) {
      for (const std::int32_t operand : operands) write(operand, place, 1, box, turned);
      return;
    }
    CsgBox middles = empty_box();
    const auto middle = [&](std::int32_t operand) {
      const CsgBox b = within(operand);
      return (b.low + b.high) / 2;
    };
    middles.low = middles.high = middle(operands.front());
    for (const std::int32_t operand : operands) {
      const Imath::V3d p = middle(operand);
      for (int a = 0; a < 3; ++a)
        middles.low[a] = std::min(middles.low[a], p[a]), middles.high[a] = std::max(middles.high[a], p[a]);
    }
    const Imath::V3d extent = middles.high - middles.low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    std::ranges::sort(operands, [&](std::int32_t a, std::int32_t b) {
      return std::pair(middle(a)[axis], a) < std::pair(middle(b)[axis], b);
    });
    const auto half = operands.begin() + static_cast<std::ptrdiff_t>(operands.size() / 2);
    for (std::vector<std::int32_t> part :
         {std::vector(operands.begin(), half), std::vector(half, operands.end())}) {
      CsgBox all = empty_box();
      for (const std::int32_t operand : part) all = hull(all, within(operand));
      const std::int32_t group = open(place, 1, all);
      write_union(std::move(part), group, all, turned);
      close(group);
    }
  }

  const CsgTree& tree_;
  const std::vector<std::int32_t> twins_;
  const std::vector<CsgBox>& boxes_;
  const Imath::V3d centre_;
  const double size_;
  CsgRecord& csg_;
};

/// Solids whose boxes hold the middle of a node's box, `most` where they are more.
std::size_t count_at_middle(const CsgRecord& csg, const CsgNode& node, std::size_t most) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < csg.nodes.size() && count < most;) {
    const CsgNode& other = csg.nodes[i];
    bool inside = true;
    for (int a = 0; a < 3; ++a) {
      const float middle = 0.5f * node.low[a] + 0.5f * node.high[a];
      inside = inside && middle >= other.low[a] && middle <= other.high[a];
    }
    count += inside && other.solid >= 0;
    i = inside ? i + 1 : static_cast<std::size_t>(other.end);
  }
  return count;
}

bool is_finite(const CsgBox& box) {
  return std::isfinite((box.high - box.low).length()) && std::isfinite(box.low.length());
}

}  // namespace

bool is_crowded(const CsgRecord& csg) {
  return std::ranges::any_of(csg.nodes, [&](const CsgNode& node) {
    return node.solid >= 0 && count_at_middle(csg, node, kCrowd) >= kCrowd;
  });
}

absl::StatusOr<bool> add_csg(const v1::Shape& shape, const CsgTree& tree, const Transform& placed_from_object,
                             const BlobSource& blobs, ShapeTable& table, ShapeRecord& record,
                             std::vector<ShapeRecord>& solids) {
  if (shape.uv_transform_size() != 0)
    return absl::InvalidArgumentError("a uv transform is for the operands, not for the combination");
  const auto where = [&](std::size_t i) {
    return place_in_scene("operand", tree.solids[i].operand, tree.solids[i].shape->name());
  };
  std::vector<CsgOperand> operands;
  for (std::size_t i = 0; i < tree.solids.size(); ++i) {
    auto operand = read_csg_operand(*tree.solids[i].shape, blobs);
    if (!operand.ok()) return located(operand.status(), where(i));
    operands.push_back(*std::move(operand));
  }
  const std::vector<CsgBox> boxes = boxes_of(tree, operands);
  const CsgBox& whole = boxes.front();
  if (whole.is_empty()) return false;
  if (!is_finite(whole))
    return absl::InvalidArgumentError(
        "it has no end that is known: intersect half-spaces with a box, or with others across all axes");

  const Imath::V3d centre = (whole.low + whole.high) / 2, half = (whole.high - whole.low) / 2;
  const double size = std::max({half.x, half.y, half.z});
  Transform combination_from_unit;
  combination_from_unit.m = {size, 0, 0, centre.x, 0, size, 0, centre.y, 0, 0, size, centre.z};
  const Transform placed_from_unit = placed_from_object * combination_from_unit;
  Transform unit_from_placed, unit_from_combination;
  if (!placed_from_unit.invert(unit_from_placed) || !combination_from_unit.invert(unit_from_combination))
    return absl::InvalidArgumentError("its transform is singular");
  if (!fits_floats(placed_from_unit, unit_from_placed)) return absl::InvalidArgumentError(kBeyondFloats);

  CsgRecord csg;
  csg.render_from_unit = placed_from_unit.to_affine();
  csg.unit_from_render = unit_from_placed.to_affine();
  csg.solids.resize(operands.size());
  NodeWriter(tree, boxes, centre, size, csg).write(0, -1, 1, whole, false);
  std::copy_n(csg.nodes.front().low, 3, csg.low);
  std::copy_n(csg.nodes.front().high, 3, csg.high);
  for (std::size_t i = 0; i < operands.size(); ++i) {
    const v1::Shape& message = *tree.solids[i].shape;
    ShapeRecord solid;
    const Transform& placed = operands[i].combination_from_object;
    if (auto s = add_csg_operand(message, placed_from_object * placed, blobs, table, solid); !s.ok())
      return located(s, where(i));
    solids.push_back(solid);
    if (message.has_mesh()) {
      auto mesh = closed_mesh_of(message.mesh(), unit_from_combination * placed, blobs);
      if (!mesh.ok()) return located(mesh.status(), where(i));
      csg.solids[i].mesh = static_cast<std::int32_t>(csg.meshes.size());
      csg.meshes.push_back(*std::move(mesh));
    } else {
      Transform own_from_combination;
      if (!operands[i].combination_from_own.invert(own_from_combination))
        return located(absl::InvalidArgumentError("its transform is singular"), where(i));
      const Transform own_from_unit = own_from_combination * combination_from_unit;
      std::copy(own_from_unit.m.begin(), own_from_unit.m.end(), csg.solids[i].object_from_unit);
    }
  }
  record.kind = ShapeKind::kCsg;
  if (shape.reverse_orientation()) record.flags ^= kFlipNormal;
  record.quadric = static_cast<std::int32_t>(table.csgs.size());
  table.csgs.push_back(std::move(csg));
  return true;
}

}  // namespace tessera::render
