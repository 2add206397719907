// The tree of a combination of solids, from its message.
#pragma once

#include <cstdint>
#include <list>
#include <vector>

#include "absl/status/statusor.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

struct CsgTree {
  struct Node {
    v1::Csg::Operation operation = v1::Csg::UNION;
    bool keeps_material = false;
    std::int32_t solid = -1;  // index in `solids`; -1: a group
    std::vector<std::int32_t> operands;
  };
  std::vector<Node> nodes;  // the whole is the first; operands stand behind their group
  struct Solid {
    const v1::Shape* shape;
    std::int32_t operand;  // number among the operands of the message
  };
  std::vector<Solid> solids;
  std::list<v1::Shape> bounds;  // solids that close implicit surfaces
};

/// InvalidArgument where groups do not end, have no operands or are too many within one another.
absl::StatusOr<CsgTree> read_csg_tree(const v1::Csg& csg);

}  // namespace tessera::render
