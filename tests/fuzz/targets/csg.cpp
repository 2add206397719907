// Combinations of solids, as text of a Shape message: what a worker makes of them is a tree that its kernels
// can walk. The blob "cube" is a closed mesh.
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include "fuzz/mutate_message.h"
#include "fuzz/target.h"
#include "render/scene/shape/csg.h"
#include "wire/csg_limits.h"
#include "wire/mesh_blob.h"

namespace tessera::fuzz {
namespace {

using render::CsgNode;
using render::CsgRecord;

const std::string& cube() {
  static const std::string bytes =
      wire::encode_mesh({{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {}, {}, {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2}});
  return bytes;
}

void check(const CsgRecord& csg) {
  const auto count = static_cast<std::int32_t>(csg.nodes.size());
  require(count > 0 && csg.nodes[0].parent < 0 && csg.nodes[0].end == count, "a tree without a root");
  for (std::int32_t i = 0; i < count; ++i) {
    const CsgNode& node = csg.nodes[static_cast<std::size_t>(i)];
    require(node.end > i && node.end <= count, "a node that ends before it begins");
    for (int a = 0; a < 3; ++a) require(node.low[a] < node.high[a], "a box without volume");
    if (node.solid >= 0) {
      require(node.end == i + 1, "a solid with operands");
      require(csg.solids.at(static_cast<std::size_t>(node.solid)).node == i, "a solid at another node");
    }
    if (i == 0) continue;
    const CsgNode& parent = csg.nodes.at(static_cast<std::size_t>(node.parent));
    require(node.parent < i && node.end <= parent.end && parent.solid < 0, "a node outside of its group");
    for (int a = 0; a < 3; ++a)
      require(node.low[a] >= parent.low[a] && node.high[a] <= parent.high[a],
              "a box beyond that of its group");
  }
  for (const render::CsgMesh& mesh : csg.meshes) {
    require(mesh.order.size() == mesh.triangles.size() / 3, "triangles that no ray can find");
    for (const render::CsgMesh::Node& node : mesh.nodes)
      require(static_cast<std::size_t>(node.first + node.count) <= mesh.order.size(),
              "a leaf behind the end");
  }
}

bool accepts_csg(std::string_view bytes) {
  v1::Shape shape;
  google::protobuf::TextFormat::Parser parser;
  parser.SetRecursionLimit(100);
  class Silent final : public google::protobuf::io::ErrorCollector {
    void AddError(int, int, const std::string&) override {}
  } silent;
  parser.RecordErrorsTo(&silent);
  if (!parser.ParseFromString(std::string(bytes), &shape)) return false;
  const auto tree = render::read_csg_tree(shape.csg());
  if (!tree.ok()) {
    require(!tree.status().message().empty(), "an error without a message");
    return false;
  }
  require(tree->solids.size() <= static_cast<std::size_t>(wire::kMostCsgSolids),
          "more solids than the limit");
  const auto blobs = [](const std::string& digest) -> absl::StatusOr<render::BlobBytes> {
    if (digest != "cube") return absl::NotFoundError("there is no blob " + digest);
    return render::BlobBytes{cube(), nullptr};
  };
  render::ShapeTable table;
  render::ShapeRecord record;
  std::vector<render::ShapeRecord> solids;
  const auto there = render::add_csg(shape, *tree, {}, blobs, table, record, solids);
  if (!there.ok()) {
    require(!there.status().message().empty(), "an error without a message");
    return false;
  }
  if (!*there) return true;
  require(solids.size() == tree->solids.size() && table.csgs.size() == 1, "solids without records");
  check(table.csgs[0]);
  return true;
}

std::string mutate_csg(std::string bytes, std::mt19937& random) {
  v1::Shape shape;
  if (random() % 8 == 0 || !google::protobuf::TextFormat::ParseFromString(bytes, &shape))
    return mutate_bytes(std::move(bytes), random);
  mutate_message(shape, random);
  google::protobuf::TextFormat::PrintToString(shape, &bytes);
  return bytes;
}

}  // namespace

const Target kCsg = {"csg", accepts_csg, mutate_csg};

}  // namespace tessera::fuzz
